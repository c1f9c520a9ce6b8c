//! Expressions in parentheses, and the names that `define` gives to numbers.

use std::f64::consts::PI;

use super::super::tokens::{LARGEST_NUMBER, quoted};
use super::words::Words;
use quadratura_base::error::Result;

/// The deepest expression, counting parentheses and powers.
const DEEPEST: usize = 64;

/// A function of one number.
type Function = fn(f64) -> f64;

/// The functions of one number, whose angles are in radians.
const FUNCTIONS: [(&str, Function); 7] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sqrt", f64::sqrt),
];

/// Names that are always known. Of an animation, the beginning is read.
const KNOWN: [(&str, f64); 5] =
    [("pi", PI), ("dtor", PI / 180.0), ("rtod", 180.0 / PI), ("time", 0.0), ("frame", 0.0)];

impl Words<'_> {
    /// `define NAME number`.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub fn define(&mut self) -> Result<()> {
        let name = self.word("the name of `define`")?;
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return Err(self.wrong(format!("`define` of {}, expected a name", quoted(&name))));
        }
        let value = self.number(&format!("the value of `define {}`", name.escape_debug()))?;
        self.values.insert(name, value);
        Ok(())
    }

    /// Reads an expression after its parenthesis, with the closing one.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub(super) fn expression(&mut self) -> Result<f64> {
        let value = self.sum(0)?;
        self.close()?;
        if value.is_finite() && value.abs() <= LARGEST_NUMBER {
            return Ok(value);
        }
        Err(self.wrong(format!("an expression whose value is {value}, expected a finite number up to 1e15")))
    }

    fn close(&mut self) -> Result<()> {
        let word = self.word("`)`")?;
        if word == ")" {
            return Ok(());
        }
        Err(self.wrong(format!("{} in an expression, expected an operator or `)`", quoted(&word))))
    }

    fn sum(&mut self, depth: usize) -> Result<f64> {
        let mut value = self.product(depth)?;
        loop {
            if self.take("+")? {
                value += self.product(depth)?;
            } else if self.take("-")? {
                value -= self.product(depth)?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self, depth: usize) -> Result<f64> {
        let mut value = self.power(depth)?;
        loop {
            if self.take("*")? {
                value *= self.power(depth)?;
            } else if self.take("/")? {
                value /= self.power(depth)?;
            } else if self.take("%")? {
                value %= self.power(depth)?;
            } else {
                return Ok(value);
            }
        }
    }

    /// Signs, and powers, which go from right to left and before signs.
    fn power(&mut self, depth: usize) -> Result<f64> {
        if depth > DEEPEST {
            return Err(self.wrong(format!("an expression more than {DEEPEST} deep")));
        }
        let mut sign = 1.0;
        loop {
            if self.take("-")? {
                sign = -sign;
            } else if !self.take("+")? {
                break;
            }
        }
        let value = self.operand(depth)?;
        let raised = if self.take("^")? { value.powf(self.power(depth + 1)?) } else { value };
        Ok(sign * raised)
    }

    fn operand(&mut self, depth: usize) -> Result<f64> {
        let word = self.word("a number of an expression")?;
        if word == "(" {
            let value = self.sum(depth + 1)?;
            return self.close().map(|()| value);
        }
        if word.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            let number = word.parse();
            return number.map_err(|_| self.wrong(format!("{}, expected a number", quoted(&word))));
        }
        if self.take("(")? {
            return self.call(&word, depth + 1);
        }
        let known = KNOWN.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
        let value = self.values.get(&word).copied().or(known);
        value.ok_or_else(|| {
            self.wrong(format!("{} in an expression, which no `define` before it names", quoted(&word)))
        })
    }

    /// Reads the arguments of a function.
    fn call(&mut self, name: &str, depth: usize) -> Result<f64> {
        let first = self.sum(depth)?;
        if name == "hypot" {
            let comma = self.word("`,`")?;
            if comma != "," {
                return Err(self.wrong(format!("{}, expected `,` of hypot(A, B)", quoted(&comma))));
            }
            let value = first.hypot(self.sum(depth)?);
            return self.close().map(|()| value);
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            let found = format!(
                "the function {}, expected sin, cos, tan, asin, acos, atan, sqrt or hypot",
                quoted(name)
            );
            return Err(self.wrong(found));
        };
        self.close()?;
        Ok(function(first))
    }
}
