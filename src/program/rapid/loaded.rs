//! Which files are loaded: parts that are loaded one after the other may share names.

use super::interpreter::Interpreter;
use super::modules::Loaded;
use super::syntax::{Args, Block, What};
use super::value::Value;
use super::why::COPY;
use crate::notes::Code;

/// The name of a file without its folders.
fn base(path: &str) -> String {
    path.rsplit(['/', '\\', ':']).next().unwrap_or(path).trim().to_lowercase()
}

impl<'a> Interpreter<'a> {
    /// `Load \Dynamic, "HOME:" \File:="a.mod";` and its like.
    pub(super) fn heed_load(&mut self, key: &str, args: &'a Args) {
        let named = match key {
            "waitload" => args.optional_value("unloadpath"),
            _ => args.positional.first(),
        };
        let part = if key == "waitload" { "unloadfile" } else { "file" };
        let file = args.optional_value(part).or(named).map(|expr| self.eval(expr));
        let file = match file {
            Some(Value::Text(text)) => Some(base(&text)),
            Some(_) => return self.loaded = Loaded::unknown(),
            None => None,
        };
        match (key, file) {
            ("load", Some(file)) => self.loaded.now.push(file),
            ("startload", Some(file)) => self.loaded.begun.push(file),
            (_, Some(file)) => self.unload(&file, args),
            (_, None) => {}
        }
        if key == "waitload" {
            let begun = std::mem::take(&mut self.loaded.begun);
            self.loaded.now.extend(begun);
        }
    }

    /// Data of a part that is loaded again are as it declares them.
    fn unload(&mut self, name: &str, args: &Args) {
        self.loaded.now.retain(|own| own != name);
        let file = self.file;
        let is_saved = args.optional.iter().any(|(own, _)| own == "save");
        for (key, data) in &file.data {
            let place = file.places.get(key).and_then(|place| place.rsplit_once(':'));
            let is_its = place.is_some_and(|(file, _)| base(file) == name);
            if !is_its || data.is_constant || file.shared.contains(key) {
                continue;
            }
            if data.is_persistent && self.written.contains(key.as_str()) {
                // Of what is saved with it the next one begins.
                if !is_saved {
                    let what =
                        format!("'{}' was in a part that UnLoad has taken away", data.name.shown);
                    self.forget(&data.name, &Value::unknown(format!("{what}: {COPY}")));
                }
            } else if !data.is_persistent {
                self.globals.remove(key.as_str());
                self.written.remove(key.as_str());
            }
        }
    }

    /// Whether the file of a procedure is loaded, of a call of one.
    pub(super) fn is_loaded(&self, call: &'a Block) -> bool {
        call.iter().any(|statement| match &statement.what {
            What::Call(name, _) => {
                let own = self.file.procedures.get(&name.key).and_then(|own| own.there.as_ref());
                own.is_none_or(|(file, _)| self.loaded.now.contains(&base(file)))
            }
            _ => false,
        })
    }

    /// Of a procedure that several parts have.
    pub(super) fn tell_not_loaded(&mut self, line: usize, shown: &str, are_several: bool) {
        let why = match (self.loaded.is_unknown, are_several) {
            (true, _) => "only the run knows which of them is loaded here",
            (false, true) => "more than one of them is loaded here",
            (false, false) => "none of them is loaded here by the name that it has in the job",
        };
        let what = format!(
            "several files have a procedure '{shown}', and {why}: call %\"module:{0}\"%, or check \
             each part in an operation of its own",
            shown.rsplit(':').next().unwrap_or(shown)
        );
        self.log.error(Code::Motion, line, what);
    }
}
