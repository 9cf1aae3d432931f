//! Enums whose variants have names, and sums whose parts have names.

/// Defines an enum and the name of each variant: `Variant => "name"`. Adds the constant `ALL`, every variant
/// in the order of the definition, and the method `name`.
#[macro_export]
macro_rules! named {
    (
        $(#[$about:meta])*
        $visible:vis enum $Enum:ident {
            $($(#[$doc:meta])* $Variant:ident $(= $code:literal)? => $name:literal,)+
        }
    ) => {
        $(#[$about])*
        $visible enum $Enum {
            $($(#[$doc])* $Variant $(= $code)?,)+
        }

        impl $Enum {
            /// Every variant, in the order of the definition.
            $visible const ALL: [$Enum; [$($name),+].len()] = [$($Enum::$Variant),+];

            /// The variant's name.
            #[must_use]
            $visible fn name(self) -> &'static str {
                match self {
                    $($Enum::$Variant => $name,)+
                }
            }
        }
    };
}

/// Defines a structure of numbers that are summed up part by part, with each part's name.
#[macro_export]
macro_rules! named_sums {
    (
        $(#[$about:meta])*
        $visible:vis struct $Sums:ident of $Number:ident {
            $($(#[$doc:meta])* $shown:vis $part:ident,)+
        }
    ) => {
        $(#[$about])*
        $visible struct $Sums {
            $($(#[$doc])* $shown $part: $Number,)+
        }

        impl $Sums {
            /// The parts with their names, for reports.
            pub fn named(&self) -> [(&'static str, $Number); [$(stringify!($part)),+].len()] {
                [$((stringify!($part), self.$part)),+]
            }

            /// Adds other sums, part by part.
            pub fn add(&mut self, other: &Self) {
                $(self.$part += other.$part;)+
            }
        }
    };
}
