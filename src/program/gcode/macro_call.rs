//! G65: the words of its block are the locals of the subprogram (Fanuc, Series 0i Operator's
//! Manual, "Custom macro", "Simple call").

use std::collections::HashMap;

use super::block::{Block, Word};
use super::flow::Flow;

const LOCALS: [(u8, i64); 21] = [
    (b'A', 1),
    (b'B', 2),
    (b'C', 3),
    (b'D', 7),
    (b'E', 8),
    (b'F', 9),
    (b'H', 11),
    (b'I', 4),
    (b'J', 5),
    (b'K', 6),
    (b'M', 13),
    (b'Q', 17),
    (b'R', 18),
    (b'S', 19),
    (b'T', 20),
    (b'X', 24),
    (b'Y', 25),
    (b'Z', 26),
    (b'U', 21),
    (b'V', 22),
    (b'W', 23),
];

/// I, J and K may stand so often: their last ones are #31 to #33.
const MOST_SETS: i64 = 10;

/// Calls the subprogram.
pub(super) fn macro_call(flow: &mut Flow<'_>, block: &Block) -> Result<(), String> {
    let number = block.get('P').ok_or("G65 without P")?;
    flow.call(number, block.get('L').unwrap_or(1.0), Some(locals(&block.words)?))
}

/// What the words give, the later where two give one local.
fn locals(words: &[Word]) -> Result<HashMap<i64, f64>, String> {
    let of_sets = || words.iter().map(|word| word.letter).filter(|letter| b"IJK".contains(letter));
    // Once each and in the alphabet's order, they are what they are without sets.
    let has_sets = of_sets().zip(of_sets().skip(1)).any(|(first, second)| first >= second);
    let mut found = HashMap::new();
    let mut set = 0;
    let mut last = 0;
    let mut seen = [0; 3];
    for &Word { letter, value, .. } in words {
        if b"GNOPL".contains(&letter) {
            continue;
        }
        let local = LOCALS.iter().find(|(own, _)| *own == letter).map(|(_, local)| *local);
        let local = local
            .ok_or_else(|| format!("G65 gives {}, which is not supported", char::from(letter)))?;
        let place = b"IJK".iter().position(|own| *own == letter).filter(|_| has_sets);
        if let Some(place) = place {
            // The next I, J or K that is not behind the last in the alphabet begins a set.
            set += i64::from(letter <= last);
            last = letter;
            if set != seen[place] {
                return Err(
                    "G65: I, J and K that stand more than once or in another order are read in \
                            whole sets, I J K I J K, of which the last alone may be cut short"
                        .to_owned(),
                );
            }
            seen[place] += 1;
        }
        if set >= MOST_SETS {
            return Err(format!("G65: I, J and K stand more than {MOST_SETS} times"));
        }
        let sets = if place.is_some() { set } else { 0 };
        found.insert(local + 3 * sets, value);
    }
    Ok(found)
}
