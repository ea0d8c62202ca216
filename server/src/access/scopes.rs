//! Scopes of keys. A scope that ends in `:own` is bound to what the owner of the key has, and to what
//! members of the owner's projects have.

/// Right to a kind of calls, which a key may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scope {
    /// Make, list and revoke keys.
    Admin,
    /// Read captures and everything that belongs to them.
    CapturesRead,
    /// Upload captures, add files to them, change, read again and delete them.
    CapturesWrite,
    /// Read fits and their losses.
    FitsRead,
    /// Start, change, cancel and delete fits.
    FitsWrite,
    /// Read the metrics of a server, and nothing else.
    MetricsRead,
    /// Rollouts, sessions, plays, plans, registrations and evaluations.
    RolloutsRun,
    /// Read and export twins.
    TwinsRead,
    /// Import, change and delete twins.
    TwinsWrite,
}

impl Scope {
    /// All scopes, in the order of their words.
    pub const ALL: [Self; 9] = [
        Self::Admin,
        Self::CapturesRead,
        Self::CapturesWrite,
        Self::FitsRead,
        Self::FitsWrite,
        Self::MetricsRead,
        Self::RolloutsRun,
        Self::TwinsRead,
        Self::TwinsWrite,
    ];

    /// The word of the scope in the API.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Admin => "admin",
            Self::CapturesRead => "captures:read",
            Self::CapturesWrite => "captures:write",
            Self::FitsRead => "fits:read",
            Self::FitsWrite => "fits:write",
            Self::MetricsRead => "metrics:read",
            Self::RolloutsRun => "rollouts:run",
            Self::TwinsRead => "twins:read",
            Self::TwinsWrite => "twins:write",
        }
    }

    /// The scope of a word.
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scope| scope.as_str() == word)
    }

    /// True if a key may have it for its owner's resources alone: keys, workers and metrics have no
    /// owner.
    pub fn has_bound(self) -> bool {
        !matches!(self, Self::Admin | Self::MetricsRead)
    }

    fn bit(self) -> u16 {
        1 << (self as u16)
    }
}

/// End of the word of a scope that is bound to what its owner has.
const OWN: &str = ":own";

/// A scope as a key has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grant {
    scope: Scope,
    /// True if it is bound to the owner's resources, and to those that projects share.
    is_own: bool,
}

impl Grant {
    /// Which scopes may be confined to what an owner has, for messages.
    pub(crate) const CONFINED: &str =
        "those of captures, fits, rollouts and twins may end in `:own`";

    /// The scope of a word, with or without a bound.
    pub(crate) fn parse(word: &str) -> Option<Self> {
        match word.strip_suffix(OWN) {
            None => Scope::parse(word).map(|scope| Self { scope, is_own: false }),
            Some(word) => Scope::parse(word)
                .filter(|scope| scope.has_bound())
                .map(|scope| Self { scope, is_own: true }),
        }
    }
}

/// A set of scopes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Scopes {
    all: u16,
    own: u16,
}

impl Scopes {
    pub(crate) const ALL: Self = Self { all: u16::MAX, own: 0 };

    /// True if it has the scope, with a bound or without.
    pub(crate) fn has(self, scope: Scope) -> bool {
        (self.all | self.own) & scope.bit() != 0
    }

    /// True if it has this scope alone.
    pub(crate) fn is(self, scope: Scope) -> bool {
        self.all | self.own == scope.bit()
    }

    /// True if it has the scope without a bound.
    pub(crate) fn reach_all(self, scope: Scope) -> bool {
        self.all & scope.bit() != 0
    }
}

impl FromIterator<Grant> for Scopes {
    fn from_iter<I: IntoIterator<Item = Grant>>(grants: I) -> Self {
        grants.into_iter().fold(Self::default(), |mut scopes, grant| {
            let bits = if grant.is_own { &mut scopes.own } else { &mut scopes.all };
            *bits |= grant.scope.bit();
            scopes
        })
    }
}
