//! The grammar of `#[problem(...)]`. The test of docs/use/errors.md reads the sources with it too.

use syn::{
    Attribute, Error, Expr, Ident, LitStr, Path, Result, Token,
    parse::{Parse, ParseStream},
};

/// A `#[problem(...)]` attribute.
pub(crate) struct Problem {
    /// The attribute's path, to point at.
    pub(crate) path: Path,
    /// Source of category and reason.
    pub(crate) origin: Origin,
    /// Delay after which another attempt makes sense.
    pub(crate) retry: Option<Expr>,
    /// The portable form.
    pub(crate) fault: Option<Expr>,
    /// Condition under which the attribute applies.
    pub(crate) condition: Option<Expr>,
}

/// Source of category and reason.
pub(crate) enum Origin {
    /// The cause has them.
    Cause,
    /// The attribute states them.
    Stated {
        /// The category.
        category: Category,
        /// The reason.
        reason: LitStr,
    },
}

/// The stated category.
pub(crate) enum Category {
    /// A variant of `Category`.
    Named(Ident),
    /// An expression over the fields.
    Computed(Box<Expr>),
}

impl Problem {
    /// The attributes of a variant or a type, in their order.
    pub(crate) fn all(attributes: &[Attribute]) -> Result<Vec<Self>> {
        let own = attributes.iter().filter(|attribute| attribute.path().is_ident("problem"));
        own.map(|attribute| {
            let arguments: Arguments = attribute.parse_args()?;
            arguments.checked(attribute.path().clone())
        })
        .collect()
    }

    /// `transparent`, as an attribute with this path.
    pub(crate) fn transparent(path: Path) -> Self {
        Self { path, origin: Origin::Cause, retry: None, fault: None, condition: None }
    }
}

/// Path of `#[error(transparent)]`, which takes the message of the cause, if it is there.
pub(crate) fn message_of_cause(attributes: &[Attribute]) -> Option<Path> {
    let is_so = |attribute: &&Attribute| {
        attribute.path().is_ident("error")
            && attribute.parse_args::<Ident>().is_ok_and(|word| word == "transparent")
    };
    attributes.iter().find(is_so).map(|attribute| attribute.path().clone())
}

/// Arguments in any order.
#[derive(Default)]
struct Arguments {
    transparent: Option<Ident>,
    category: Option<Category>,
    reason: Option<LitStr>,
    retry: Option<Expr>,
    fault: Option<Expr>,
    condition: Option<Expr>,
}

impl Parse for Arguments {
    fn parse(input: ParseStream<'_>) -> Result<Self> {
        let mut found = Self::default();
        while !input.is_empty() {
            let start = input.span();
            let is_new = if input.peek(Token![if]) {
                input.parse::<Token![if]>()?;
                found.condition.replace(input.parse()?).is_none()
            } else if input.peek(LitStr) {
                found.reason.replace(input.parse()?).is_none()
            } else if input.peek(Ident) && input.peek2(Token![=]) {
                let name: Ident = input.parse()?;
                input.parse::<Token![=]>()?;
                let value = match name.to_string().as_str() {
                    "retry" => &mut found.retry,
                    "fault" => &mut found.fault,
                    _ => return Err(Error::new(name.span(), "expected `retry` or `fault`")),
                };
                value.replace(input.parse()?).is_none()
            } else {
                match named(input.parse()?) {
                    Category::Named(word) if word == "transparent" => {
                        found.transparent.replace(word).is_none()
                    }
                    category => found.category.replace(category).is_none(),
                }
            };
            if !is_new {
                return Err(Error::new(start, "this is said twice"));
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(found)
    }
}

/// An expression of one word is a variant of `Category`.
fn named(expr: Expr) -> Category {
    let word = match &expr {
        Expr::Path(path) => path.path.get_ident().cloned(),
        _ => None,
    };
    word.map_or_else(|| Category::Computed(Box::new(expr)), Category::Named)
}

impl Arguments {
    fn checked(self, path: Path) -> Result<Problem> {
        let Self { transparent, category, reason, retry, fault, condition } = self;
        let origin = match (transparent, category, reason) {
            (Some(_), None, None) => Origin::Cause,
            (None, Some(category), Some(reason)) => {
                check_reason(&reason)?;
                Origin::Stated { category, reason }
            }
            _ => {
                let usage = "expected a category and a reason, like `#[problem(NotFound, \"FIT_NOT_FOUND\")]`, or \
                             `#[problem(transparent)]` where the cause has them";
                return Err(Error::new_spanned(path, usage));
            }
        };
        Ok(Problem { path, origin, retry, fault, condition })
    }
}

fn check_reason(reason: &LitStr) -> Result<()> {
    let is_word = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit())
    };
    if reason.value().split('_').all(is_word) {
        return Ok(());
    }
    Err(Error::new(reason.span(), "a reason is a word in UPPER_SNAKE_CASE"))
}
