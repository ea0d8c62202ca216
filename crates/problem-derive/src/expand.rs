//! The implementation of `Problem` for a type with `#[problem(...)]` attributes.

use proc_macro2::{TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use syn::{
    Attribute, Data, DeriveInput, Error, Field, Fields, Ident, Result, spanned::Spanned as _,
};

use crate::attribute::{Category, Origin, Problem, message_of_cause};

/// A variant, or the whole of a struct.
struct Case<'a> {
    /// `Self::Variant`, or `Self`.
    path: TokenStream,
    fields: &'a Fields,
    problems: Vec<Problem>,
}

/// The implementation.
///
/// # Errors
/// If an attribute is missing or contradicts itself.
pub(crate) fn problem(input: &DeriveInput) -> Result<TokenStream> {
    let (mut facts, mut faults, mut carries_fault) =
        (TokenStream::new(), TokenStream::new(), false);
    for case in cases(input)? {
        case.check()?;
        for problem in &case.problems {
            facts.extend(case.arm(problem, &case.facts(problem)?));
            let fault = problem.fault.as_ref().map(|fault| quote!(#fault));
            carries_fault |= fault.is_some();
            let fault = fault.unwrap_or_else(|| quote!(::bendtwin_core::Fault::of(self)));
            faults.extend(case.arm(problem, &fault));
        }
    }
    let fault = carries_fault.then(|| {
        quote! { fn fault(&self) -> ::bendtwin_core::Fault { match self { #faults } } }
    });
    let name = &input.ident;
    let (generics, arguments, bounds) = input.generics.split_for_impl();
    Ok(quote! {
        #[automatically_derived]
        impl #generics ::bendtwin_core::Problem for #name #arguments #bounds {
            fn facts(&self) -> ::bendtwin_core::error::Facts {
                match self { #facts }
            }
            #fault
        }
    })
}

fn cases(input: &DeriveInput) -> Result<Vec<Case<'_>>> {
    match &input.data {
        Data::Struct(of) => {
            let problems = stated(&input.attrs, &[], &input.ident)?;
            Ok(vec![Case { path: quote!(Self), fields: &of.fields, problems }])
        }
        Data::Enum(of) => {
            let variants = of.variants.iter();
            variants
                .map(|variant| {
                    let name = &variant.ident;
                    let problems = stated(&variant.attrs, &input.attrs, name)?;
                    Ok(Case { path: quote!(Self::#name), fields: &variant.fields, problems })
                })
                .collect()
        }
        Data::Union(of) => Err(Error::new_spanned(of.union_token, "a union is no error")),
    }
}

/// The attributes of a variant, or else those of its type.
fn stated(own: &[Attribute], of_type: &[Attribute], name: &Ident) -> Result<Vec<Problem>> {
    let found = Problem::all(own)?;
    if !found.is_empty() {
        return Ok(found);
    }
    if let Some(path) = message_of_cause(own) {
        return Ok(vec![Problem::transparent(path)]);
    }
    let found = Problem::all(of_type)?;
    if !found.is_empty() {
        return Ok(found);
    }
    let missing = format!(
        "`{name}` has no category and reason: say `#[problem(NotFound, \"ITS_REASON\")]` beside its message, or \
         `#[problem(transparent)]` where the cause has them"
    );
    Err(Error::new(name.span(), missing))
}

impl Case<'_> {
    /// Checks that one attribute applies in every case, and each in some.
    fn check(&self) -> Result<()> {
        let last = self.problems.len() - 1;
        for (place, problem) in self.problems.iter().enumerate() {
            let fault = match (&problem.condition, place == last) {
                (Some(_), true) => "the last `#[problem]` is for all other cases: it has no `if`",
                (None, false) => "this `#[problem]` without `if` hides those after it",
                _ => continue,
            };
            return Err(Error::new_spanned(&problem.path, fault));
        }
        Ok(())
    }

    /// The field of the cause, with its binding.
    fn cause(&self, problem: &Problem) -> Result<(Ident, &Field)> {
        let is_named = |(name, _): &(Ident, &Field)| name == "error" || name == "source";
        let found = match self.fields.len() {
            1 => self.bindings().next(),
            _ => self.bindings().find(is_named),
        };
        let missing = "the cause is the only field, or the one that is named `error` or `source`";
        found.ok_or_else(|| Error::new_spanned(&problem.path, missing))
    }

    /// The fields by the names that expressions have for them.
    fn bindings(&self) -> impl Iterator<Item = (Ident, &Field)> {
        let named = |(place, field): (usize, &Field)| {
            field.ident.clone().unwrap_or_else(|| format_ident!("_{place}"))
        };
        self.fields.iter().enumerate().map(move |entry| (named(entry), entry.1))
    }

    /// The facts that an attribute states.
    fn facts(&self, problem: &Problem) -> Result<TokenStream> {
        let retry = problem.retry.as_ref().map(|delay| quote!(::core::convert::Into::into(#delay)));
        let path = quote!(::bendtwin_core::error::Facts);
        match &problem.origin {
            Origin::Stated { category, reason } => {
                let category = match category {
                    Category::Named(name) => quote!(::bendtwin_core::Category::#name),
                    Category::Computed(expr) => quote!(#expr),
                };
                let retry = retry.unwrap_or_else(|| quote!(::core::option::Option::None));
                Ok(quote!(#path { category: #category, reason: #reason, retry_after: #retry }))
            }
            Origin::Cause => {
                let (cause, field) = self.cause(problem)?;
                // Where the cause is no problem, the compiler points at its type.
                let facts =
                    quote_spanned!(field.ty.span() => ::bendtwin_core::Problem::facts(#cause));
                Ok(match retry {
                    Some(retry) => quote!(#path { retry_after: #retry, ..#facts }),
                    None => facts,
                })
            }
        }
    }

    /// A match arm, whose pattern binds the fields that its condition and its value mention.
    fn arm(&self, problem: &Problem, value: &TokenStream) -> TokenStream {
        let guard = problem.condition.as_ref().map(|condition| quote!(if #condition));
        let used = |name: &Ident| mentions(&guard, name) || mentions(value, name);
        let path = &self.path;
        let fields = match self.fields {
            Fields::Named(_) => {
                let bound = self.bindings().map(|(name, _)| name).filter(used);
                quote!({ #(#bound,)* .. })
            }
            Fields::Unnamed(_) => {
                let bound = self
                    .bindings()
                    .map(|(name, _)| if used(&name) { name.to_token_stream() } else { quote!(_) });
                quote!((#(#bound),*))
            }
            Fields::Unit => TokenStream::new(),
        };
        quote! { #path #fields #guard => #value, }
    }
}

/// True if tokens contain a name.
fn mentions(tokens: impl ToTokens, name: &Ident) -> bool {
    tokens.to_token_stream().into_iter().any(|token| match token {
        TokenTree::Ident(word) => word == *name,
        TokenTree::Group(group) => mentions(group.stream(), name),
        _ => false,
    })
}

#[cfg(test)]
mod tests;
