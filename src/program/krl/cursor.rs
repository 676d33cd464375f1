//! Expressions of KRL: tokens → syntax tree. Multiplication binds stronger than addition, that than
//! AND, EXOR and OR, in this order.

use super::lexer::Kind;
use super::syntax::{Expr, Path};
use super::value::Sort;

/// Blocks and expressions in one another beyond this are no program that a person writes.
pub(super) const MAX_DEPTH: usize = 40;

/// How strongly comparisons bind as they are meant, and what stands in them.
const COMPARISON: u8 = 3;
const SUM: u8 = 4;
const FRAMES: u8 = 6;

/// Operators beside each other.
#[derive(Debug, Clone, Copy, Default)]
struct Joined {
    by_comparison: bool,
    /// AND, OR, EXOR.
    by_word: bool,
}

/// A place among the tokens of a line.
pub(super) struct Cursor<'t> {
    pub(super) tokens: &'t [Kind],
    pub(super) at: usize,
    depth: usize,
    /// Which operators stand beside each other outside of inner parentheses.
    joined: Joined,
    /// Whether comparisons bind weakest.
    compares_last: bool,
}

impl<'t> Cursor<'t> {
    pub(super) fn new(tokens: &'t [Kind]) -> Self {
        Self { tokens, at: 0, depth: 0, joined: Joined::default(), compares_last: false }
    }

    pub(super) fn behind(&mut self, count: usize) -> Result<&mut Self, String> {
        self.at += count;
        Ok(self)
    }

    pub(super) fn peek(&self) -> Option<&'t Kind> {
        self.tokens.get(self.at)
    }

    pub(super) fn take(&mut self, symbol: &str) -> bool {
        let found = matches!(self.peek(), Some(Kind::Symbol(found)) if *found == symbol);
        self.at += usize::from(found);
        found
    }

    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let found = matches!(self.peek(), Some(Kind::Word(found)) if found == word);
        self.at += usize::from(found);
        found
    }

    pub(super) fn symbol(&mut self, symbol: &str) -> Result<(), String> {
        if self.take(symbol) { Ok(()) } else { Err(format!("expected '{symbol}'")) }
    }

    pub(super) fn word(&mut self, word: &str) -> Result<(), String> {
        if self.take_word(word) { Ok(()) } else { Err(format!("expected {}", word.to_uppercase())) }
    }

    pub(super) fn name(&mut self) -> Result<String, String> {
        match self.peek() {
            Some(Kind::Word(word)) => {
                self.at += 1;
                Ok(word.clone())
            }
            _ => Err("expected a name".to_owned()),
        }
    }

    pub(super) fn is_end(&self) -> bool {
        self.at >= self.tokens.len()
    }

    pub(super) fn path(&mut self) -> Result<Path, String> {
        let name = self.name()?;
        let (mut indices, mut fields) = (Vec::new(), Vec::new());
        loop {
            if self.take("[") {
                // `TEXT[]`, `BOARD[,]`: all of it.
                while !self.take("]") {
                    if !self.take(",") {
                        indices.push(self.expression()?);
                        self.take(",");
                    }
                }
            } else if self.take(".") {
                fields.push(self.name()?);
            } else {
                return Ok(Path { name, indices, fields });
            }
        }
    }

    /// Arguments up to `)`; those left out are `None`.
    pub(super) fn arguments(&mut self) -> Result<Vec<Option<Expr>>, String> {
        let mut found = Vec::new();
        loop {
            if self.take(")") {
                return Ok(found);
            }
            if self.take(",") {
                found.push(None);
                continue;
            }
            found.push(Some(self.expression()?));
            if self.take(")") {
                return Ok(found);
            }
            self.symbol(",")?;
        }
    }

    pub(super) fn expression(&mut self) -> Result<Expr, String> {
        let (start, outside) = (self.at, std::mem::take(&mut self.joined));
        let meant = self.binary(0)?;
        let is_mixed = self.joined.by_comparison && self.joined.by_word;
        let found = if is_mixed && !self.compares_last {
            let end = std::mem::replace(&mut self.at, start);
            self.compares_last = true;
            let other = self.binary(0);
            self.compares_last = false;
            if self.at != end {
                return Err("put parentheses around each comparison".to_owned());
            }
            Expr::TwoWays(Box::new([meant, other?]))
        } else {
            meant
        };
        self.joined = outside;
        Ok(found)
    }

    fn binary(&mut self, weakest: u8) -> Result<Expr, String> {
        if self.depth >= MAX_DEPTH {
            return Err("the expression is nested too deep".to_owned());
        }
        self.depth += 1;
        let found = self.binary_inside(weakest);
        self.depth -= 1;
        found
    }

    fn binary_inside(&mut self, weakest: u8) -> Result<Expr, String> {
        let mut left = self.unary()?;
        while let Some((operator, strength)) = self.operator() {
            if strength < weakest {
                break;
            }
            self.at += 1;
            match operator {
                "and" | "or" | "exor" | "b_and" | "b_or" | "b_exor" => self.joined.by_word = true,
                "+" | "-" | "*" | "/" | ":" => {}
                _ => self.joined.by_comparison = true,
            }
            let right = self.binary(strength + 1)?;
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    /// The operator that stands here, and how strongly it binds.
    fn operator(&self) -> Option<(&'static str, u8)> {
        let [comparison, or, exor, and] =
            if self.compares_last { [0, 1, 2, 3] } else { [COMPARISON, 0, 1, 2] };
        let found = match self.peek()? {
            Kind::Symbol(symbol @ ("==" | "<>" | "<" | "<=" | ">" | ">=")) => (*symbol, comparison),
            Kind::Symbol(symbol @ ("+" | "-")) => (*symbol, SUM),
            Kind::Symbol(symbol @ ("*" | "/")) => (*symbol, 5),
            Kind::Symbol(":") => (":", FRAMES),
            Kind::Word(word) => match word.as_str() {
                "or" => ("or", or),
                "exor" => ("exor", exor),
                "and" => ("and", and),
                "b_or" => ("b_or", or),
                "b_exor" => ("b_exor", exor),
                "b_and" => ("b_and", and),
                _ => return None,
            },
            _ => return None,
        };
        Some(found)
    }

    fn unary(&mut self) -> Result<Expr, String> {
        if self.take("-") {
            let inner = self.binary(FRAMES)?;
            return Ok(Expr::Minus(Box::new(inner)));
        }
        if self.take("+") {
            return self.binary(FRAMES);
        }
        if self.take_word("not") {
            let weakest = if self.compares_last { SUM } else { COMPARISON };
            return Ok(Expr::Not(Box::new(self.binary(weakest)?)));
        }
        if self.take_word("b_not") {
            let inner = self.binary(FRAMES + 1)?;
            let ones = Expr::Number(-1.0, None, Sort::Whole);
            return Ok(Expr::Binary("b_exor", Box::new(inner), Box::new(ones)));
        }
        self.primary()
    }

    fn primary(&mut self) -> Result<Expr, String> {
        let Some(token) = self.peek() else { return Err("expected a value".to_owned()) };
        match token {
            Kind::Number(value, span, is_whole) => {
                self.at += 1;
                let sort = if *is_whole { Sort::Whole } else { Sort::Real };
                Ok(Expr::Number(*value, *span, sort))
            }
            Kind::Text(text) => {
                self.at += 1;
                Ok(Expr::Text(text.clone()))
            }
            Kind::Enum(name) => {
                self.at += 1;
                Ok(Expr::Enum(name.clone()))
            }
            Kind::Symbol("(") => {
                self.at += 1;
                let inner = self.expression()?;
                self.symbol(")")?;
                Ok(inner)
            }
            Kind::Symbol("{") => {
                self.at += 1;
                self.aggregate()
            }
            Kind::Word(word) if matches!(word.as_str(), "true" | "false") => {
                self.at += 1;
                Ok(Expr::Bool(word == "true"))
            }
            Kind::Word(_) => {
                let path = self.path()?;
                if self.take("(") {
                    return Ok(Expr::Call(path.name, self.arguments()?));
                }
                Ok(Expr::Ref(path))
            }
            Kind::Symbol(symbol) => Err(format!("expected a value, found '{symbol}'")),
        }
    }

    /// `{E6POS: X 1, Y 2}`, `{X 1,Y 2}`; behind the brace.
    fn aggregate(&mut self) -> Result<Expr, String> {
        if let (Some(Kind::Word(_)), Some(Kind::Symbol(":"))) =
            (self.peek(), self.tokens.get(self.at + 1))
        {
            self.at += 2;
        }
        let mut parts = Vec::new();
        loop {
            if self.take("}") {
                return Ok(Expr::Parts(parts));
            }
            let name = self.name()?;
            if self.take("[") {
                // `POINT2[] " "`, `DATA[1] 5`.
                while !self.take("]") {
                    self.expression()?;
                }
            }
            parts.push((name, self.expression()?));
            if !self.take(",") {
                self.symbol("}")?;
                return Ok(Expr::Parts(parts));
            }
        }
    }
}
