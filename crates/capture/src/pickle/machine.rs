//! The pickle machine: a stack, a memo and an arena of values. Containers hold
//! indices into the arena, so depth costs neither call stack nor drop stack.

use std::borrow::Cow;

use super::{
    Dialect, Id, Value,
    input::Input,
    lines,
    numpy::{Descr, Global, Parsed, Parts},
    torch,
};
use crate::{Error, Limits, array::Array, limits::Budget};

/// Description of a fault, before the file's name is added.
pub(super) enum Fault {
    Damaged(&'static str),
    Global(String),
    Refused(String),
    Dtype(String),
    Other(Error),
}

impl Fault {
    pub(super) fn damaged(what: &'static str) -> Self {
        Self::Damaged(what)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

const UNDERFLOW: Fault = Fault::Damaged("its stack runs empty");

pub(super) struct Machine<'a, 'b> {
    at: &'b str,
    input: Input<'a>,
    dialect: Dialect,
    limits: &'b Limits,
    budget: &'b mut Budget,
    values: Vec<Value<'a>>,
    /// Nesting below each value, at the time when it was made or last added to.
    depths: Vec<u16>,
    stack: Vec<Id>,
    marks: Vec<usize>,
    memo: Vec<Option<Id>>,
}

impl<'a, 'b> Machine<'a, 'b> {
    pub(super) fn new(
        at: &'b str,
        input: &'a [u8],
        dialect: Dialect,
        limits: &'b Limits,
        budget: &'b mut Budget,
    ) -> Self {
        Self {
            at,
            input: Input(input),
            dialect,
            limits,
            budget,
            values: Vec::new(),
            depths: Vec::new(),
            stack: Vec::new(),
            marks: Vec::new(),
            memo: Vec::new(),
        }
    }

    /// Runs to the end; returns all values and the root.
    pub(super) fn run(mut self) -> Result<(Vec<Value<'a>>, Id), Error> {
        let at = self.at.to_owned();
        match self.steps() {
            Ok(root) => Ok((self.values, root)),
            Err(Fault::Damaged(fault)) => Err(Error::Damaged { at, fault: fault.to_owned() }),
            Err(Fault::Global(global)) if self.dialect == Dialect::Torch => {
                let fault = format!(
                    "the archive asks to load `{global}`: only tensors, dictionaries, lists and numbers are read"
                );
                Err(Error::Pickle { at, fault })
            }
            Err(Fault::Global(global)) => Err(Error::PickleGlobal { at, global }),
            Err(Fault::Refused(fault)) => Err(Error::Pickle { at, fault }),
            Err(Fault::Dtype(found)) => Err(Error::Dtype {
                at,
                found,
                needed: "little-endian bool, integers, float32 or float64",
            }),
            Err(Fault::Other(error)) => Err(error),
        }
    }

    fn steps(&mut self) -> Result<Id, Fault> {
        for _ in 0..self.limits.pickle_opcodes {
            let opcode = self.input.byte()?;
            if opcode == b'.' {
                return self.stack.pop().ok_or(UNDERFLOW);
            }
            self.step(opcode)?;
        }
        Err(Fault::Refused(format!(
            "the pickle has more than {} opcodes: save numpy arrays, not lists of numbers",
            self.limits.pickle_opcodes
        )))
    }

    fn step(&mut self, opcode: u8) -> Result<(), Fault> {
        match opcode {
            // PROTO, FRAME
            0x80 => match self.input.byte()? {
                0..=5 => Ok(()),
                p => Err(Fault::Refused(format!("pickle protocol {p} (known are 0 to 5)"))),
            },
            0x95 => self.input.take(8).map(|_| ()),
            // MARK, POP, POP_MARK, DUP
            b'(' => {
                if self.marks.len() >= self.limits.pickle_depth {
                    return Err(self.too_deep());
                }
                self.marks.push(self.stack.len());
                Ok(())
            }
            b'0' => self.pop().map(|_| ()),
            b'1' => self.pop_to_mark().map(|_| ()),
            b'2' => {
                let top = *self.stack.last().ok_or(UNDERFLOW)?;
                self.stack.push(top);
                Ok(())
            }
            b'N' => self.push(Value::None, 0),
            0x88 => self.push(Value::Bool(true), 0),
            0x89 => self.push(Value::Bool(false), 0),
            b'J' | b'K' | b'M' | 0x8a | b'G' => self.number(opcode),
            b'X' | 0x8c | 0x8d | b'T' | b'U' => self.text(opcode),
            b'I' | b'L' | b'F' | b'S' | b'V' => {
                let line = self.input.line_bytes()?;
                if matches!(opcode, b'S' | b'V') {
                    // Latin-1 takes up to two bytes a letter.
                    self.budget.take(2 * line.len() as u64, self.at)?;
                }
                let value = lines::value(opcode, line)?;
                self.push(value, 0)
            }
            b'B' | b'C' | 0x8e | 0x96 => {
                let bytes = self.input.prefixed(match opcode {
                    b'C' => 1,
                    b'B' => 4,
                    _ => 8,
                })?;
                self.push(Value::Bytes(Cow::Borrowed(bytes)), 0)
            }
            b']' | b'l' | b')' | b't' | 0x85..=0x87 | b'}' | b'd' => self.container(opcode),
            b'a' | b'e' | b's' | b'u' => self.add(opcode),
            // PUT, GET, BINPUT, LONG_BINPUT, MEMOIZE, BINGET, LONG_BINGET
            b'p' | b'g' => {
                let key = self
                    .input
                    .line()?
                    .parse()
                    .map_err(|_| Fault::Damaged("a memo in it has no number"))?;
                if opcode == b'p' { self.memoize(key) } else { self.recall(key) }
            }
            b'q' => {
                let key = self.input.unsigned(1)?;
                self.memoize(key)
            }
            b'r' => {
                let key = self.input.unsigned(4)?;
                self.memoize(key)
            }
            0x94 => self.memoize(self.memo.len() as u64),
            b'h' => {
                let key = self.input.unsigned(1)?;
                self.recall(key)
            }
            b'j' => {
                let key = self.input.unsigned(4)?;
                self.recall(key)
            }
            b'c' => {
                let (module, name) = (self.input.line()?, self.input.line()?);
                self.global(module, name)
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let (Value::Str(module), Value::Str(name)) = (self.at(module), self.at(name))
                else {
                    return Err(Fault::Damaged("it names a global that is no text"));
                };
                let (module, name) = (module.clone(), name.clone());
                self.global(&module, &name)
            }
            b'R' => self.call(),
            // BINPERSID
            b'Q' if self.dialect == Dialect::Torch => {
                let id = self.pop()?;
                let storage = torch::storage(&Parts { values: &self.values }, self.at(id))?;
                self.push(Value::Storage(storage), 0)
            }
            b'b' => self.set_state(),
            _ => Err(Fault::Refused(format!(
                "the pickle uses opcode 0x{opcode:02x}, which plain numpy arrays do not need"
            ))),
        }
    }

    // Values.

    fn at(&self, id: Id) -> &Value<'a> {
        // Ids come from `push` alone, so each has a value.
        self.values.get(id as usize).unwrap_or(&Value::None)
    }

    fn push(&mut self, value: Value<'a>, depth: u16) -> Result<(), Fault> {
        if usize::from(depth) > self.limits.pickle_depth {
            return Err(self.too_deep());
        }
        let id = Id::try_from(self.values.len()).map_err(|_| self.too_deep())?;
        self.values.push(value);
        self.depths.push(depth);
        self.stack.push(id);
        Ok(())
    }

    fn pop(&mut self) -> Result<Id, Fault> {
        // Values below the last mark belong to the container in the making.
        if self.stack.len() <= self.marks.last().copied().unwrap_or(0) {
            return Err(UNDERFLOW);
        }
        self.stack.pop().ok_or(UNDERFLOW)
    }

    fn pop_to_mark(&mut self) -> Result<Vec<Id>, Fault> {
        let mark = self.marks.pop().ok_or(UNDERFLOW)?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    fn too_deep(&self) -> Fault {
        Fault::Refused(format!("the pickle nests deeper than {}", self.limits.pickle_depth))
    }

    fn depth_over(&self, items: &[Id]) -> u16 {
        let deepest = items.iter().filter_map(|id| self.depths.get(*id as usize)).max();
        deepest.map_or(1, |d| d.saturating_add(1))
    }

    fn memoize(&mut self, key: u64) -> Result<(), Fault> {
        let top = *self.stack.last().ok_or(UNDERFLOW)?;
        let key = usize::try_from(key).unwrap_or(usize::MAX);
        // Python numbers memo entries consecutively: a jump is an attempt on the memory.
        if key > self.memo.len() + 1024 || key >= self.limits.pickle_opcodes {
            return Err(Fault::Refused(format!("the pickle jumps to memo entry {key}")));
        }
        if key >= self.memo.len() {
            self.memo.resize(key + 1, None);
        }
        self.memo[key] = Some(top);
        Ok(())
    }

    fn recall(&mut self, key: u64) -> Result<(), Fault> {
        let entry = usize::try_from(key).ok().and_then(|k| self.memo.get(k).copied().flatten());
        self.stack.push(entry.ok_or(Fault::Damaged("it refers to a value that it has not made"))?);
        Ok(())
    }

    // Opcodes.

    fn number(&mut self, opcode: u8) -> Result<(), Fault> {
        let value = match opcode {
            b'J' => Value::Int(i64::from(self.input.unsigned(4)? as u32 as i32)),
            b'K' => Value::Int(self.input.unsigned(1)? as i64),
            b'M' => Value::Int(self.input.unsigned(2)? as i64),
            // The one number of a pickle that is big-endian.
            b'G' => Value::Float(f64::from_bits(self.input.unsigned(8)?.swap_bytes())),
            _ => {
                let bytes = self.input.prefixed(1)?;
                if bytes.len() > 8 {
                    return Err(Fault::Refused("the pickle has an integer beyond 64 bits".into()));
                }
                let negative = bytes.last().is_some_and(|b| b & 0x80 != 0);
                let mut full = if negative { [0xff; 8] } else { [0; 8] };
                full[..bytes.len()].copy_from_slice(bytes);
                Value::Int(i64::from_le_bytes(full))
            }
        };
        self.push(value, 0)
    }

    fn text(&mut self, opcode: u8) -> Result<(), Fault> {
        let bytes = self.input.prefixed(match opcode {
            0x8c | b'U' => 1,
            b'X' | b'T' => 4,
            _ => 8,
        })?;
        if matches!(opcode, b'T' | b'U') {
            return self.push(lines::str_of_python_2(bytes), 0);
        }
        let text =
            std::str::from_utf8(bytes).map_err(|_| Fault::Damaged("a word in it is no text"))?;
        self.push(Value::Str(Cow::Borrowed(text)), 0)
    }

    fn container(&mut self, opcode: u8) -> Result<(), Fault> {
        let items = match opcode {
            b']' | b')' | b'}' => Vec::new(),
            0x85..=0x87 => {
                let mut items = Vec::with_capacity(3);
                for _ in 0x84..opcode {
                    items.push(self.pop()?);
                }
                items.reverse();
                items
            }
            _ => self.pop_to_mark()?,
        };
        let depth = self.depth_over(&items);
        let value = match opcode {
            b']' | b'l' => Value::List(items),
            b'}' | b'd' => Value::Dict(pairs(&items)?),
            _ => Value::Tuple(items),
        };
        self.push(value, depth)
    }

    fn add(&mut self, opcode: u8) -> Result<(), Fault> {
        let items = match opcode {
            b'a' => vec![self.pop()?],
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                vec![key, value]
            }
            _ => self.pop_to_mark()?,
        };
        let target = *self.stack.last().ok_or(UNDERFLOW)? as usize;
        let depth = self.depth_over(&items);
        if usize::from(depth) > self.limits.pickle_depth {
            return Err(self.too_deep());
        }
        match self.values.get_mut(target) {
            Some(Value::List(list)) if matches!(opcode, b'a' | b'e') => list.extend(items),
            Some(Value::Dict(dict)) if matches!(opcode, b's' | b'u') => dict.extend(pairs(&items)?),
            _ => return Err(Fault::Damaged("it adds to something that is no container")),
        }
        if let Some(d) = self.depths.get_mut(target) {
            *d = depth.max(*d);
        }
        Ok(())
    }

    fn global(&mut self, module: &str, name: &str) -> Result<(), Fault> {
        let torch = match self.dialect {
            Dialect::Torch => torch::Global::find(module, name),
            Dialect::Numpy => None,
        };
        match (Global::find(module, name), torch) {
            (Some(global), _) => self.push(Value::Global(global), 0),
            (None, Some(global)) => self.push(Value::TorchGlobal(global), 0),
            (None, None) => {
                // A file may name anything at any length.
                let full: String = module.chars().chain(".".chars()).chain(name.chars()).collect();
                Err(Fault::Global(full.chars().filter(|c| !c.is_control()).take(120).collect()))
            }
        }
    }

    fn call(&mut self) -> Result<(), Fault> {
        let (args, callee) = (self.pop()?, self.pop()?);
        let (callee, args) = match (self.at(callee), self.at(args)) {
            (callee @ (Value::Global(_) | Value::TorchGlobal(_)), Value::Tuple(args)) => {
                (callee.clone(), few(args)?)
            }
            _ => return Err(Fault::Damaged("it calls something that is no function")),
        };
        let global = match callee {
            Value::Global(global) => global,
            Value::TorchGlobal(global) => {
                let value = global.call(&Parts { values: &self.values }, &args)?;
                return self.push(value, 1);
            }
            _ => return Err(Fault::Damaged("it calls something that is no function")),
        };
        let parts = Parts { values: &self.values };
        let value = match global {
            Global::Reconstruct => Value::EmptyArray,
            Global::FromBuffer => {
                Value::Array(finish(self.budget, self.at, parts.of_buffer(&args)?)?)
            }
            Global::Scalar => parts.scalar(&args)?,
            Global::Dtype => {
                let word = parts.str(&args, 0).ok_or(Fault::Damaged("a dtype without a type"))?;
                Value::Dtype(Descr::new(&word.chars().take(16).collect::<String>()))
            }
            Global::Encode => {
                let text = parts.str(&args, 0).ok_or(Fault::Damaged("bytes that are no text"))?;
                self.budget.take(text.len() as u64, self.at)?;
                let bytes =
                    text.chars().map(|c| u8::try_from(u32::from(c))).collect::<Result<_, _>>();
                Value::Bytes(Cow::Owned(bytes.map_err(|_| Fault::Damaged("bytes beyond latin-1"))?))
            }
            Global::Bytes if args.is_empty() => Value::Bytes(Cow::Borrowed(&[])),
            Global::Bytes | Global::NdArray => {
                return Err(Fault::Refused("the pickle builds an object in an unusual way".into()));
            }
        };
        self.push(value, 1)
    }

    fn set_state(&mut self) -> Result<(), Fault> {
        let state = self.pop()?;
        let target = *self.stack.last().ok_or(UNDERFLOW)?;
        let Value::Tuple(state) = self.at(state) else {
            return Err(Fault::Damaged("it sets a state that is no tuple"));
        };
        let state = few(state)?;
        let parts = Parts { values: &self.values };
        let value = match self.at(target) {
            Value::Dtype(descr) => {
                let mut descr = descr.clone();
                descr.set_order(parts.str(&state, 1).unwrap_or("|"));
                Value::Dtype(descr)
            }
            Value::EmptyArray => {
                Value::Array(finish(self.budget, self.at, parts.of_state(&state)?)?)
            }
            _ => return Err(Fault::Damaged("it sets the state of something that has none")),
        };
        if let Some(slot) = self.values.get_mut(target as usize) {
            *slot = value;
        }
        Ok(())
    }
}

/// The items of a call, copied; numpy's own calls have at most nine.
fn few(items: &[Id]) -> Result<Vec<Id>, Fault> {
    if items.len() > 16 {
        return Err(Fault::Refused("the pickle calls with more arguments than numpy takes".into()));
    }
    Ok(items.to_vec())
}

/// An array from its parts; bytes of the file stay where they are.
fn finish<'a>(budget: &mut Budget, at: &str, parts: Parsed<'_, 'a>) -> Result<Array<'a>, Fault> {
    if let Cow::Owned(bytes) = parts.data {
        // Copied here, and once more when the array is taken out.
        budget.take(2 * bytes.len() as u64, at)?;
    }
    Ok(Array::new(at, parts.dtype, parts.shape, parts.fortran, parts.data.clone())?)
}

fn pairs(items: &[Id]) -> Result<Vec<(Id, Id)>, Fault> {
    let (pairs, rest) = items.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(Fault::Damaged("a dictionary in it has a key without a value"));
    }
    Ok(pairs.iter().map(|[k, v]| (*k, *v)).collect())
}
