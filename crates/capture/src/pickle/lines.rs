//! Values of the protocols 0 and 1, which are lines of text.

use std::borrow::Cow;

use super::{Value, machine::Fault};

const NO_NUMBER: Fault = Fault::Damaged("a number in it is no number");
const NO_TEXT: Fault = Fault::Damaged("a word in it is no text");

/// The value of a line after its opcode: `I` and `L` an integer (or a truth value), `F` a float, `S`
/// a str of Python 2, `V` a text.
pub(super) fn value<'a>(opcode: u8, line: &'a [u8]) -> Result<Value<'a>, Fault> {
    let number = || std::str::from_utf8(line).map(str::trim).map_err(|_| NO_NUMBER);
    Ok(match opcode {
        b'I' if line == b"00" => Value::Bool(false),
        b'I' if line == b"01" => Value::Bool(true),
        b'I' | b'L' => {
            let digits = number()?.trim_end_matches('L');
            Value::Int(digits.parse().map_err(|_| NO_NUMBER)?)
        }
        b'F' => Value::Float(number()?.parse().map_err(|_| NO_NUMBER)?),
        b'S' => str_of_python_2(quoted(line)?),
        _ => Value::Str(Cow::Owned(text(line)?)),
    })
}

/// A str of Python 2: bytes in arrays, words elsewhere.
pub(super) fn str_of_python_2<'a>(bytes: impl Into<Cow<'a, [u8]>>) -> Value<'a> {
    match bytes.into() {
        Cow::Borrowed(bytes) => match std::str::from_utf8(bytes) {
            Ok(text) if text.len() < 64 => Value::Str(Cow::Borrowed(text)),
            _ => Value::Bytes(Cow::Borrowed(bytes)),
        },
        Cow::Owned(bytes) => match String::from_utf8(bytes) {
            Ok(text) if text.len() < 64 => Value::Str(Cow::Owned(text)),
            Ok(text) => Value::Bytes(Cow::Owned(text.into_bytes())),
            Err(error) => Value::Bytes(Cow::Owned(error.into_bytes())),
        },
    }
}

/// The bytes of a literal such as `'\x00a'`.
fn quoted(line: &[u8]) -> Result<Vec<u8>, Fault> {
    let inside = match line {
        [first @ (b'\'' | b'"'), inside @ .., last] if first == last => inside,
        _ => return Err(NO_TEXT),
    };
    let mut bytes = Vec::with_capacity(inside.len());
    let mut rest = inside;
    while let [byte, after @ ..] = rest {
        rest = after;
        if *byte != b'\\' {
            bytes.push(*byte);
            continue;
        }
        let [letter, after @ ..] = rest else { return Err(NO_TEXT) };
        rest = after;
        let byte = match letter {
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            b'a' => 0x07,
            b'b' => 0x08,
            b'f' => 0x0c,
            b'v' => 0x0b,
            b'\\' | b'\'' | b'"' => *letter,
            b'x' => {
                let (digits, after) = rest.split_at_checked(2).ok_or(NO_TEXT)?;
                rest = after;
                hex(digits)? as u8
            }
            b'0'..=b'7' => {
                let more = rest.iter().take(2).take_while(|b| (b'0'..=b'7').contains(*b)).count();
                let (digits, after) = rest.split_at(more);
                rest = after;
                let octal = std::iter::once(letter).chain(digits);
                octal.fold(0_u32, |n, digit| n * 8 + u32::from(digit - b'0')) as u8
            }
            other => {
                bytes.push(b'\\');
                *other
            }
        };
        bytes.push(byte);
    }
    Ok(bytes)
}

/// A text in Latin-1 with `\u` and four, or `\U` and eight digits for other letters.
fn text(line: &[u8]) -> Result<String, Fault> {
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    while let [byte, after @ ..] = rest {
        rest = after;
        let count = match (byte, rest) {
            (b'\\', [b'u', ..]) => 4,
            (b'\\', [b'U', ..]) => 8,
            _ => {
                text.push(char::from(*byte));
                continue;
            }
        };
        let (digits, after) = rest[1..].split_at_checked(count).ok_or(NO_TEXT)?;
        rest = after;
        text.push(char::from_u32(hex(digits)?).ok_or(NO_TEXT)?);
    }
    Ok(text)
}

fn hex(digits: &[u8]) -> Result<u32, Fault> {
    digits.iter().try_fold(0_u32, |n, digit| {
        let value = char::from(*digit).to_digit(16).ok_or(NO_TEXT)?;
        Ok(n << 4 | value)
    })
}
