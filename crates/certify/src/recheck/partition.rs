//! Checks that boxes divide a domain: they cover it, share no inner points and do not extend outside.
//!
//! Only comparisons of the stated numbers are used, no volumes. The domain and then each part is cut by
//! planes that no box crosses, until a part holds a single box, which must equal it. That proves coverage and
//! disjointness at once, and succeeds on every subdivision that was made by repeated cuts.

/// Largest number of boxes examined, summed over all cuts. Bisections examine each box once a level: a
/// million boxes, cut to a depth of 64, stay below it.
const BUDGET: usize = 1 << 27;

/// Reason why boxes do not divide their domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The domain itself is invalid: an end is not finite, or the lower exceeds the upper.
    #[error("the domain is not a box: each range needs finite ends, the lower first")]
    NoDomain,
    /// The box of this index is invalid, or flat along an axis where the domain is not.
    #[error("box {} is invalid: each range needs finite ends, the lower first, and a width", .0 + 1)]
    NoBox(usize),
    /// The box of this index extends outside the domain.
    #[error("box {} extends outside the domain", .0 + 1)]
    Outside(usize),
    /// No box holds the inner points of this part.
    #[error("the boxes do not cover the domain: none holds {0:?}")]
    Gap(Vec<[f64; 2]>),
    /// Boxes overlap within this part, or cannot be separated by planes.
    #[error("boxes overlap within {0:?}")]
    Overlap(Vec<[f64; 2]>),
    /// There are too many boxes, too irregularly placed.
    #[error("there are too many boxes, too irregularly placed, to be checked")]
    TooIntricate,
}

/// Checks that the boxes divide `domain`. Every box has a range for each axis.
///
/// # Errors
/// The first [`Fault`] found.
pub fn divides<B: AsRef<[[f64; 2]]>>(domain: &[[f64; 2]], boxes: &[B]) -> Result<(), Fault> {
    let is_box = |one: &[[f64; 2]]| one.iter().all(|[lo, hi]| lo.is_finite() && hi.is_finite() && lo <= hi);
    if !is_box(domain) {
        return Err(Fault::NoDomain);
    }
    for (i, one) in boxes.iter().map(AsRef::as_ref).enumerate() {
        let axes = || one.iter().zip(domain);
        if one.len() != domain.len()
            || !is_box(one)
            || axes().any(|([lo, hi], [from, to])| from < to && !(lo < hi))
        {
            return Err(Fault::NoBox(i));
        }
        if axes().any(|([lo, hi], [from, to])| lo < from || hi > to) {
            return Err(Fault::Outside(i));
        }
    }
    let mut budget = BUDGET;
    let mut waiting = vec![(domain.to_vec(), boxes.iter().map(AsRef::as_ref).collect::<Vec<_>>())];
    while let Some((part, mut inside)) = waiting.pop() {
        match inside.as_slice() {
            [] => return Err(Fault::Gap(part)),
            [one] if *one == part => continue,
            [_] => return Err(Fault::Gap(part)),
            _ => {}
        }
        budget = budget.checked_sub(inside.len()).ok_or(Fault::TooIntricate)?;
        let cut = (0..part.len()).find_map(|axis| cut(&part, &mut inside, axis));
        waiting.extend(cut.ok_or(Fault::Overlap(part))?);
    }
    Ok(())
}

/// A part of the domain, and the boxes in it.
type Part<'a> = (Vec<[f64; 2]>, Vec<&'a [[f64; 2]]>);

/// The parts and their boxes between all planes across `axis` that no box crosses; `None` if there is no such
/// plane.
fn cut<'a>(part: &[[f64; 2]], boxes: &mut [&'a [[f64; 2]]], axis: usize) -> Option<Vec<Part<'a>>> {
    let [from, to] = part[axis];
    if from == to {
        return None;
    }
    boxes.sort_by(|one, two| one[axis][0].total_cmp(&two[axis][0]));
    let (mut parts, mut begin, mut low) = (Vec::new(), 0, from);
    let mut reach = f64::NEG_INFINITY;
    for i in 0..=boxes.len() {
        let next = boxes.get(i).map_or(to, |one| one[axis][0]);
        if i > 0 && reach <= next {
            let mut between = part.to_vec();
            between[axis] = [low, next];
            parts.push((between, boxes[begin..i].to_vec()));
            (begin, low) = (i, next);
        }
        if let Some(one) = boxes.get(i) {
            reach = reach.max(one[axis][1]);
        }
    }
    (parts.len() > 1).then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validated::tile::GroupBox;

    fn divides(domain: &GroupBox, boxes: &[GroupBox]) -> Result<(), Fault> {
        let boxes: Vec<_> = boxes.iter().map(GroupBox::ranges).collect();
        super::divides(&domain.ranges(), &boxes)
    }

    fn domain() -> GroupBox {
        GroupBox { a: [0.1, 0.15], k: [0.15, 0.25], b: [0.01, 0.02] }
    }

    #[test]
    fn gaps_overlaps_and_boxes_turned_round_are_found() {
        let whole = domain();
        let [low, high] = whole.halves(1);
        let [near, far] = high.halves(0);
        assert_eq!(divides(&whole, &[whole]), Ok(()));
        assert_eq!(divides(&whole, &[far, low, near]), Ok(()));
        for gap in [&[low, near][..], &[low, far], &[near], &[]] {
            assert!(matches!(divides(&whole, gap), Err(Fault::Gap(_))), "{gap:?}");
        }
        let short = GroupBox { b: [far.b[0], far.b[1].next_down()], ..far };
        assert!(matches!(divides(&whole, &[low, near, short]), Err(Fault::Gap(_))));
        for twice in [&[whole, whole][..], &[low, near, far, far], &[low, high, far]] {
            assert!(matches!(divides(&whole, twice), Err(Fault::Overlap(_))), "{twice:?}");
        }
        let turned = GroupBox { a: [whole.a[1], whole.a[0]], ..whole };
        assert_eq!(divides(&whole, &[whole, turned]), Err(Fault::NoBox(1)));
        assert_eq!(divides(&turned, &[turned]), Err(Fault::NoDomain));
        let endless = GroupBox { a: [0.1, f64::INFINITY], ..whole };
        assert_eq!(divides(&endless, &[endless]), Err(Fault::NoDomain));
        let nothing = GroupBox { a: [0.1, f64::NAN], ..whole };
        assert_eq!(divides(&whole, &[nothing]), Err(Fault::NoBox(0)));
        let large = GroupBox { k: [0.15, 0.25_f64.next_up()], ..whole };
        assert_eq!(divides(&whole, &[large]), Err(Fault::Outside(0)));
        // A flat box in the middle has no inner points, and hides none.
        let flat = GroupBox { a: [0.12, 0.12], ..whole };
        assert_eq!(divides(&whole, &[whole, flat]), Err(Fault::NoBox(1)));
    }

    #[test]
    fn a_flat_domain_is_divided_along_the_others() {
        let whole = GroupBox { b: [0.0, 0.0], ..domain() };
        let [low, high] = whole.halves(0);
        assert_eq!(divides(&whole, &[high, low]), Ok(()));
        let thick = GroupBox { b: [0.0, 0.1], ..high };
        assert_eq!(divides(&whole, &[thick, low]), Err(Fault::Outside(0)));
        let point = GroupBox { a: [0.1, 0.1], k: [0.2, 0.2], b: [0.0, 0.0] };
        assert_eq!(divides(&point, &[point]), Ok(()));
        assert!(matches!(divides(&point, &[point, point]), Err(Fault::Overlap(_))));
    }
}
