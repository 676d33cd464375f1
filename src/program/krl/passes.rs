//! Loops whose end depends on what the job assumes, or on nothing that they set: where none of that
//! changes in a pass, there is no end.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::open::names_set;
use super::run::{Deciding, Run};
use super::syntax::{Block, Expr, What};
use super::value::Value;
use super::walk::{blocks_in, expressions, functions_in, names_in};
use super::words::sets_motion;

impl<'a> Run<'a> {
    /// What decides how a loop with moves goes on, if the job assumes any of it or the loop sets
    /// none.
    pub(super) fn deciding(&mut self, body: &'a Block, conditions: Vec<&'a Expr>) -> Deciding<'a> {
        let place = std::ptr::from_ref(body);
        if let Some(known) = self.loops.get(&place) {
            return known.clone();
        }
        let found = self.names_deciding(body, conditions).map(Rc::new);
        self.loops.insert(place, found.clone());
        found
    }

    fn names_deciding(
        &self,
        body: &'a Block,
        conditions: Vec<&'a Expr>,
    ) -> Option<HashSet<&'a str>> {
        let all = self.reached(body.iter().map(|own| &own.what).collect());
        let moves = all.iter().any(|what| matches!(what, What::Move(_) | What::Spline(..)));
        if !moves || self.calls_a_routine(conditions.clone()) {
            return None;
        }
        let mut open = names_in(conditions);
        // What a datum is worked out of.
        let mut sources: HashMap<&str, Vec<&str>> = HashMap::new();
        for what in all {
            let used = names_in(expressions(what));
            for name in names_set(what) {
                sources.entry(name).or_default().extend(&used);
            }
            let mut calls = functions_in(expressions(what));
            match what {
                What::Call(name, args) => calls.push((name, args)),
                What::Return(_) => open.extend(used),
                _ if !blocks_in(what).is_empty() => open.extend(used),
                _ => {}
            }
            for (name, args) in calls {
                let routine = self.file.routine(name);
                let parameters = routine.into_iter().flat_map(|own| &own.parameters);
                for (parameter, arg) in parameters.zip(args) {
                    let given = names_in(arg.iter().collect());
                    for datum in given {
                        sources.entry(datum).or_default().push(&parameter.name);
                        sources.entry(&parameter.name).or_default().push(datum);
                    }
                }
            }
        }
        let mut found = HashSet::new();
        while let Some(name) = open.pop() {
            if found.insert(name) {
                open.extend(sources.get(name).into_iter().flatten());
            }
        }
        // What stands in no data that are compared.
        let is_beside = |name: &&str| {
            name.starts_with("$pos_") || name.starts_with("$axis_") || sets_motion(name)
        };
        let is_set = found.iter().any(|name| sources.contains_key(name));
        let is_assumed = self.settings.assume.keys().any(|said| {
            let names = self.names(&self.file.signals.key(said.clone()));
            names.iter().chain([said]).any(|name| found.contains(name_of(name)))
        });
        ((is_assumed || !is_set) && !found.iter().any(is_beside)).then_some(found)
    }

    /// The values of the data of these names.
    pub(super) fn values_of(&self, names: &HashSet<&str>) -> HashMap<String, Value> {
        let own = self.frames.last().into_iter().flat_map(|frame| &frame.data);
        let all = self.globals.iter().chain(&self.components).chain(own);
        let is_asked = |key: &str| {
            let others = self.file.signals.names_of(key).iter().map(String::as_str);
            others.chain([key]).any(|own| names.contains(name_of(own)))
        };
        let asked = all.filter(|(key, _)| is_asked(key));
        asked.map(|(key, value)| (key.clone(), value.clone())).collect()
    }
}

/// The name of the datum that an element, a component or `$MODE_OP==#EX` is of.
fn name_of(key: &str) -> &str {
    key.split(['[', '.', '=']).next().unwrap_or(key)
}
