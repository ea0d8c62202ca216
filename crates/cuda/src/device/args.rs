//! Argument structs of kernels. Each is declared once in CUDA C++ (`kernels/`) and once here, field
//! by field under the same names; [`Checks`] compares the two whenever a kernel is compiled.

mod instance;
mod kernels;
mod objective;
mod splat;

use std::{collections::BTreeSet, fmt::Write as _, marker::PhantomData};

use bytemuck::{Pod, Zeroable};

pub(crate) use self::{instance::*, kernels::*, objective::*, splat::*};

/// Device address of values of a type; null by default.
#[repr(transparent)]
pub(crate) struct Pointer<T> {
    address: u64,
    values: PhantomData<T>,
}

impl<T> Pointer<T> {
    pub(crate) fn new(address: u64) -> Self {
        Self { address, values: PhantomData }
    }

    /// The address as a number.
    pub(crate) fn address(self) -> u64 {
        self.address
    }

    pub(crate) fn is_null(self) -> bool {
        self.address == 0
    }

    /// The address with another type of values.
    pub(crate) fn cast<U>(self) -> Pointer<U> {
        Pointer::new(self.address)
    }

    /// Address of the value `count` places on.
    pub(crate) fn add(self, count: usize) -> Self {
        Self::new(self.address + (count * size_of::<T>()) as u64)
    }
}

impl<T> Clone for Pointer<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Pointer<T> {}

impl<T> Default for Pointer<T> {
    fn default() -> Self {
        Self::new(0)
    }
}

impl<T> std::fmt::Debug for Pointer<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:#x}", self.address)
    }
}

// SAFETY: a number beside a type without size; zero is null.
unsafe impl<T> Zeroable for Pointer<T> {}
// SAFETY: as above: any number is an address, valid or not.
unsafe impl<T: 'static> Pod for Pointer<T> {}

/// Types that kernels read and write, with their layout.
pub(crate) trait DeviceType {
    /// Adds the layout of this type, and of all that it holds and points to.
    fn check(checks: &mut Checks);
}

/// `static_assert`s that refuse to compile a kernel whose structs differ from the host's.
#[derive(Debug, Default)]
pub(crate) struct Checks {
    text: String,
    known: BTreeSet<&'static str>,
}

impl Checks {
    /// Begins a struct of this name and size, unless it is known already.
    pub(crate) fn begin(&mut self, name: &'static str, bytes: usize) -> bool {
        let is_new = self.known.insert(name);
        if is_new {
            // Writing to a string cannot fail.
            let _ = writeln!(
                self.text,
                r#"static_assert(sizeof({name}) == {bytes}, "{name} has {bytes} bytes on the host");"#
            );
        }
        is_new
    }

    /// Adds a field: its first byte in the struct, and how many it has.
    pub(crate) fn field(&mut self, name: &str, field: &str, first: usize, bytes: usize) {
        let _ = writeln!(
            self.text,
            "static_assert(OFFSET_OF({name}, {field}) == {first} && sizeof({name}::{field}) == {bytes}, \
             \"{name}::{field} has {bytes} bytes from byte {first} on the host\");"
        );
    }

    /// The checks, in CUDA C++.
    pub(crate) fn text(self) -> String {
        self.text
    }
}

/// Declares a struct as kernels have it, and its layout for [`Checks`].
macro_rules! device_struct {
    ($(#[$attribute:meta])* $name:ident { $($(#[$of_field:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name {
            $($(#[$of_field])* pub(crate) $field: $type,)*
        }

        impl $crate::device::args::DeviceType for $name {
            fn check(checks: &mut $crate::device::args::Checks) {
                let name = stringify!($name);
                if !checks.begin(name, size_of::<Self>()) {
                    return;
                }
                $(
                    let first = std::mem::offset_of!(Self, $field);
                    checks.field(name, stringify!($field), first, size_of::<$type>());
                )*
                $(<$type as $crate::device::args::DeviceType>::check(checks);)*
            }
        }
    };
}
use device_struct;

/// Numbers have no layout to check.
macro_rules! numbers {
    ($($type:ty),*) => {
        $(impl DeviceType for $type {
            fn check(_: &mut Checks) {}
        })*
    };
}
numbers!(u16, u32, u64, i32, f32, f64);

impl<T: DeviceType, const N: usize> DeviceType for [T; N] {
    fn check(checks: &mut Checks) {
        T::check(checks);
    }
}

impl<T: DeviceType> DeviceType for Pointer<T> {
    fn check(checks: &mut Checks) {
        T::check(checks);
    }
}
