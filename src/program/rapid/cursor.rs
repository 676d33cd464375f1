//! A place among the tokens, and the parser of expressions and arguments.

use std::collections::HashSet;

use super::lexer::{Kind, Lexer, Token, unescaped};
use super::modules::{Module, Renamed, named};
use crate::program::span::Span;

use super::syntax::{Args, Expr, Name, Operator, Optional, Path, Step};
use super::walk::all_of;

/// Expressions in one another that can be read in two ways.
const MAX_WAYS: usize = 4;

/// Nesting beyond this is no program that a person or a post-processor writes.
const MAX_EXPRESSION_DEPTH: usize = 40;

#[derive(Clone)]
pub(super) struct Cursor<'a> {
    lexer: Lexer<'a>,
    next: Option<Token<'a>>,
    /// Tokens passed so far.
    place: usize,
    line: usize,
    depth: usize,
    /// Names that its modules have otherwise, and the module that is read.
    renamed: &'a Renamed,
    module: Module,
    /// The last token says that what follows is a field or an optional parameter.
    names_part: bool,
    /// Names that the routine at hand declares itself, in lower case.
    own: HashSet<String>,
}

/// Why the tokens are no RAPID: a lower-case fragment.
pub(super) type Parsed<T> = Result<T, String>;

impl<'a> Cursor<'a> {
    /// `file`: the main one is the first.
    pub(super) fn new(text: &'a str, file: usize, renamed: &'a Renamed) -> Self {
        let (lexer, module) = (Lexer::new(text), (file, String::new()));
        let mut cursor = Self {
            lexer,
            next: None,
            place: 0,
            line: 1,
            depth: 0,
            renamed,
            module,
            names_part: false,
            own: HashSet::new(),
        };
        cursor.advance();
        cursor
    }

    /// Names are those of this module from here on.
    pub(super) fn enter(&mut self, module: &Name) {
        self.module.1.clone_from(&module.key);
    }

    /// The module that is read, in lower case.
    pub(super) fn module(&self) -> &str {
        &self.module.1
    }

    /// A routine begins: it has declared nothing yet.
    pub(super) fn enter_routine(&mut self) {
        self.own.clear();
    }

    /// A name that the routine at hand declares itself, or that a record has for a field.
    pub(super) fn own_name(&mut self, is_of_routine: bool) -> Parsed<Name> {
        self.names_part = true;
        let name = self.name()?;
        if is_of_routine {
            self.own.insert(name.key.clone());
        }
        Ok(name)
    }

    /// What a word names here.
    pub(super) fn named(&self, word: &str) -> Name {
        let own = self.renamed.get(&self.module).filter(|_| !self.names_part);
        let name = named(word, own);
        if self.own.contains(&word.to_lowercase()) { Name::new(word) } else { name }
    }

    pub(super) fn peek(&self) -> Option<Kind<'a>> {
        self.next.map(|token| token.kind)
    }

    /// Line of the next token, or of the last one at the end.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// Place of the next token in the text of the main file.
    fn span(&self) -> Option<Span> {
        self.next.map(|token| token.span).filter(|_| self.module.0 == 0)
    }

    pub(super) fn place(&self) -> usize {
        self.place
    }

    pub(super) fn advance(&mut self) {
        self.names_part = matches!(self.peek(), Some(Kind::Symbol("." | "\\")));
        self.next = self.lexer.next();
        self.line = self.next.map_or(self.line, |token| token.line);
        self.place += 1;
    }

    pub(super) fn is_symbol(&self, symbol: &str) -> bool {
        matches!(self.peek(), Some(Kind::Symbol(found)) if found == symbol)
    }

    pub(super) fn is_word(&self, keyword: &str) -> bool {
        matches!(self.peek(), Some(Kind::Word(word)) if word.eq_ignore_ascii_case(keyword))
    }

    pub(super) fn is_any_word(&self, keywords: &[&str]) -> bool {
        keywords.iter().any(|keyword| self.is_word(keyword))
    }

    pub(super) fn take_symbol(&mut self, symbol: &str) -> bool {
        let found = self.is_symbol(symbol);
        if found {
            self.advance();
        }
        found
    }

    pub(super) fn take_word(&mut self, keyword: &str) -> bool {
        let found = self.is_word(keyword);
        if found {
            self.advance();
        }
        found
    }

    pub(super) fn symbol(&mut self, symbol: &str) -> Parsed<()> {
        if self.take_symbol(symbol) { Ok(()) } else { Err(self.expected(&format!("'{symbol}'"))) }
    }

    pub(super) fn word(&mut self, keyword: &str) -> Parsed<()> {
        if self.take_word(keyword) { Ok(()) } else { Err(self.expected(keyword)) }
    }

    pub(super) fn name(&mut self) -> Parsed<Name> {
        match self.peek() {
            Some(Kind::Word(word)) => {
                let name = self.named(word);
                self.advance();
                Ok(name)
            }
            _ => Err(self.expected("a name")),
        }
    }

    /// Whether a number follows that runs into a word: `4THEN`.
    pub(super) fn is_glued(&self) -> bool {
        match self.peek() {
            Some(Kind::Stray(text)) => {
                let begins = text.starts_with(|c: char| c.is_ascii_digit() || c == '.');
                let head = text.get(..2).unwrap_or_default().to_lowercase();
                let has_radix = matches!(head.as_str(), "0x" | "0b" | "0o");
                begins && !has_radix && text.parse::<f64>().is_err()
            }
            _ => false,
        }
    }

    pub(super) fn expected(&self, what: &str) -> String {
        let found = match self.peek() {
            Some(Kind::Stray(text)) if self.is_glued() => {
                let start: String = text.chars().take(20).collect();
                return format!("'{start}' is a number that runs into a word: put a space between");
            }
            None => "the end of the file".to_owned(),
            Some(Kind::Word(word)) => format!("'{word}'"),
            Some(Kind::Number(number)) => format!("{number}"),
            Some(Kind::Symbol(symbol)) => format!("'{symbol}'"),
            Some(Kind::Text(_)) => "a string".to_owned(),
            Some(Kind::Stray(text)) => {
                let start: String = text.chars().take(20).collect();
                format!("'{start}'")
            }
        };
        format!("expected {what}, found {found}")
    }

    /// Past the next `;`, or before a keyword that only ever starts a line of structure.
    pub(super) fn skip_statement(&mut self) {
        while let Some(kind) = self.peek() {
            if self.is_any_word(&["ENDPROC", "ENDFUNC", "ENDTRAP", "ENDMODULE"]) {
                return;
            }
            self.advance();
            if kind == Kind::Symbol(";") {
                return;
            }
        }
    }

    /// An expression of any kind.
    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.binary(0)
    }

    fn binary(&mut self, weakest: u8) -> Parsed<Expr> {
        self.depth += 1;
        let parsed = self.binary_inside(weakest);
        self.depth -= 1;
        parsed
    }

    fn binary_inside(&mut self, weakest: u8) -> Parsed<Expr> {
        if self.depth > MAX_EXPRESSION_DEPTH {
            return Err("the expression is nested too deep".to_owned());
        }
        let negates = self.is_word("NOT");
        let mut left = self.unary()?;
        // What NOT is over where it is over all that AND joins.
        let mut negated = match &left {
            // Each in another doubles what is kept.
            Expr::Not(inner) if negates && ways_in(inner) >= MAX_WAYS => {
                return Err("NOT stands before AND in too many others".to_owned());
            }
            Expr::Not(inner) if negates => Some((*inner.clone(), false)),
            _ => None,
        };
        while let Some((operator, strength)) = self.operator() {
            if strength < weakest {
                break;
            }
            self.advance();
            let right = self.binary(strength + 1)?;
            negated = match (operator, negated) {
                (Operator::And, Some((all, _))) => {
                    let right = Box::new(right.clone());
                    Some((Expr::Binary(operator, Box::new(all), right), true))
                }
                (_, negated) => {
                    left = either_way(left, negated);
                    None
                }
            };
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(either_way(left, negated))
    }

    fn operator(&self) -> Option<(Operator, u8)> {
        let found = match self.peek()? {
            Kind::Symbol("=") => (Operator::Equal, 2),
            Kind::Symbol("<>") => (Operator::Unequal, 2),
            Kind::Symbol("<") => (Operator::Less, 2),
            Kind::Symbol("<=") => (Operator::LessOrEqual, 2),
            Kind::Symbol(">") => (Operator::Greater, 2),
            Kind::Symbol(">=") => (Operator::GreaterOrEqual, 2),
            Kind::Symbol("+") => (Operator::Plus, 3),
            Kind::Symbol("-") => (Operator::Minus, 3),
            Kind::Symbol("*") => (Operator::Times, 4),
            Kind::Symbol("/") => (Operator::Over, 4),
            Kind::Word(_) if self.is_word("OR") => (Operator::Or, 0),
            Kind::Word(_) if self.is_word("XOR") => (Operator::Xor, 0),
            Kind::Word(_) if self.is_word("AND") => (Operator::And, 1),
            Kind::Word(_) if self.is_word("DIV") => (Operator::Div, 4),
            Kind::Word(_) if self.is_word("MOD") => (Operator::Mod, 4),
            _ => return None,
        };
        Some(found)
    }

    fn unary(&mut self) -> Parsed<Expr> {
        let mut minus = false;
        while self.is_symbol("-") || self.is_symbol("+") {
            minus ^= self.is_symbol("-");
            self.advance();
        }
        let operand = if self.take_word("NOT") {
            Expr::Not(Box::new(self.binary(2)?))
        } else {
            self.primary()?
        };
        Ok(match (minus, operand) {
            (false, operand) => operand,
            (true, Expr::Number(number, _)) => Expr::Number(-number, None),
            (true, operand) => Expr::Minus(Box::new(operand)),
        })
    }

    fn primary(&mut self) -> Parsed<Expr> {
        match self.peek() {
            Some(Kind::Number(number)) => {
                let span = self.span();
                self.advance();
                Ok(Expr::Number(number, span))
            }
            Some(Kind::Text(text)) => {
                self.advance();
                Ok(Expr::Text(unescaped(text)))
            }
            Some(Kind::Symbol("(")) => {
                self.advance();
                let inner = self.binary(0)?;
                self.symbol(")")?;
                Ok(inner)
            }
            Some(Kind::Symbol("[")) => {
                self.advance();
                Ok(Expr::List(self.list("]")?))
            }
            Some(Kind::Word(word)) => {
                let span = self.span();
                let name = self.named(word);
                self.advance();
                if word.eq_ignore_ascii_case("TRUE") || word.eq_ignore_ascii_case("FALSE") {
                    return Ok(Expr::Bool(word.eq_ignore_ascii_case("TRUE")));
                }
                if self.take_symbol("(") {
                    let args = self.arguments(")")?;
                    return Ok(Expr::Call(Box::new((name, args))));
                }
                let path = self.path(name)?;
                Ok(Expr::Ref(Box::new(Path { span, ..path })))
            }
            _ => Err(self.expected("a value")),
        }
    }

    /// Expressions between commas up to and including `end`.
    pub(super) fn list(&mut self, end: &str) -> Parsed<Vec<Expr>> {
        let mut items = Vec::new();
        if self.take_symbol(end) {
            return Ok(items);
        }
        loop {
            items.push(self.binary(0)?);
            if self.take_symbol(end) {
                return Ok(items);
            }
            self.symbol(",")?;
        }
    }

    /// Indices and fields after a name.
    pub(super) fn path(&mut self, name: Name) -> Parsed<Path> {
        let mut steps = Vec::new();
        loop {
            if self.take_symbol("{") {
                steps.push(Step::Index(self.list("}")?));
            } else if self.take_symbol(".") {
                steps.push(Step::Field(self.name()?.key));
            } else {
                return Ok(Path { name, steps, span: None });
            }
        }
    }

    /// Arguments of an instruction or a function up to and including `end`.
    pub(super) fn arguments(&mut self, end: &str) -> Parsed<Args> {
        let mut args = Args::default();
        loop {
            if self.take_symbol(end) {
                return Ok(args);
            } else if self.take_symbol(",") {
            } else if self.take_symbol("\\") {
                let name = self.name()?.key;
                let value = if self.take_symbol(":=") {
                    Optional::Value(self.expression()?)
                } else if self.take_symbol("?") {
                    Optional::IfPresent(self.name()?)
                } else {
                    Optional::Switch
                };
                args.optional.push((name, value));
                self.between_arguments(end)?;
            } else {
                args.positional.push(self.expression()?);
                self.between_arguments(end)?;
            }
        }
    }

    fn between_arguments(&self, end: &str) -> Parsed<()> {
        let fits = self.is_symbol(",") || self.is_symbol("\\") || self.is_symbol(end);
        if fits { Ok(()) } else { Err(self.expected(&format!("',' or '{end}'"))) }
    }
}

/// Expressions that can be read in two ways, one in another, along the first of both.
fn ways_in(expr: &Expr) -> usize {
    all_of(vec![expr]).iter().filter(|own| matches!(own, Expr::TwoWays(_))).count()
}

/// `first` with NOT over its first part alone, and what NOT may be over instead, if AND joins more.
fn either_way(first: Expr, negated: Option<(Expr, bool)>) -> Expr {
    match negated {
        Some((all, true)) => Expr::TwoWays(Box::new([Expr::Not(Box::new(all)), first])),
        _ => first,
    }
}
