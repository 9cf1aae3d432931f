//! Enums whose variants have names.

/// Defines an enum and the name of each variant: `Variant => "name"`. Adds the constant `ALL`, every variant in the order
/// of the definition, and the method `name`.
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

pub(crate) use named;
