//! The stack machine that executes pickles.

use std::borrow::Cow;
use std::collections::HashMap;

use super::error::{MAX_INSTRUCTIONS, PickleError};
use super::globals;
use super::node::{Id, Node};
use super::scan::Scan;
use super::value::{Pickle, Value};

const NEWEST_PROTOCOL: u8 = 5;

/// The state of a dtype has eight entries, the most of all calls.
const MAX_ARGUMENTS: usize = 8;

pub(super) struct Machine<'a> {
    pub(super) scan: Scan<'a>,
    nodes: Vec<Node<'a>>,
    stack: Vec<Id>,
    /// Stack heights at the open marks.
    marks: Vec<usize>,
    memo: HashMap<u64, Id>,
    /// Bytes of strings copied so far.
    copied: usize,
    /// The limit is the size of the pickle: each string is copied at most once, unless one is
    /// decoded repeatedly to exhaust memory.
    most_copied: usize,
    /// Whether persistent identifiers are allowed.
    persistent: bool,
}

/// Executes the program. Each instruction adds at most one value, one reference and one memo entry,
/// so the limit of instructions bounds them all.
pub(super) fn run(bytes: &[u8], persistent: bool) -> Result<Pickle<'_>, PickleError> {
    let mut machine = Machine {
        scan: Scan::new(bytes),
        nodes: Vec::new(),
        stack: Vec::new(),
        marks: Vec::new(),
        memo: HashMap::new(),
        copied: 0,
        most_copied: bytes.len(),
        persistent,
    };
    for _ in 0..MAX_INSTRUCTIONS {
        let instruction = machine.scan.next_instruction()?;
        if instruction == b'.' {
            return machine.finish();
        }
        machine.step(instruction)?;
    }
    Err(PickleError::TooMany { what: "instructions", most: MAX_INSTRUCTIONS })
}

impl<'a> Machine<'a> {
    fn finish(mut self) -> Result<Pickle<'a>, PickleError> {
        let root = self.pop()?;
        if !self.stack.is_empty() || !self.marks.is_empty() {
            return Err(self.scan.malformed("values left on the stack at the end"));
        }
        match self.scan.left() {
            0 => Ok(Pickle { nodes: self.nodes, root }),
            count => Err(PickleError::Trailing { count }),
        }
    }

    fn step(&mut self, instruction: u8) -> Result<(), PickleError> {
        match instruction {
            b'(' => self.marks.push(self.stack.len()),
            b'0' => self.discard_one()?,
            b'1' => drop(self.pop_to_mark()?),
            b'2' => {
                let top = self.top()?;
                self.stack.push(top);
            }
            b'R' | 0x81 => {
                let (args, callee) = (self.pop()?, self.pop()?);
                let args = self.arguments(args)?;
                self.push_called(callee, &args)?;
            }
            b'b' => {
                let (state, object) = (self.pop()?, self.top()?);
                self.build(object, state)?;
            }
            b'i' => {
                let callee = self.global_lines()?;
                let args = self.pop_to_mark()?;
                self.push(callee);
                let callee = self.pop()?;
                self.push_called(callee, &args)?;
            }
            b'o' => {
                let args = self.pop_to_mark()?;
                let Some((&callee, args)) = args.split_first() else {
                    return Err(self.scan.malformed("nothing to call"));
                };
                self.push_called(callee, args)?;
            }
            b'p' | b'q' | b'r' | b'g' | b'h' | b'j' | 0x94 => self.memo(instruction)?,
            b'a' | b'e' | b's' | b'u' => self.fill(instruction)?,
            0x90 => self.add_to_set()?,
            0x80 => self.check_protocol()?,
            0x95 => self.check_frame()?,
            _ => {
                let node = self.make(instruction)?;
                self.push(node);
            }
        }
        Ok(())
    }

    /// Drops the items above the mark: those of sets are of no use here.
    fn add_to_set(&mut self) -> Result<(), PickleError> {
        drop(self.pop_to_mark()?);
        let set = self.value(self.top()?);
        if matches!(set.node(), Node::Set) {
            return Ok(());
        }
        Err(self.scan.malformed(format!("must be a set, got {}", set.kind())))
    }

    fn check_protocol(&mut self) -> Result<(), PickleError> {
        let version = self.scan.byte()?;
        if version <= NEWEST_PROTOCOL {
            return Ok(());
        }
        let problem = format!("protocol must be at most {NEWEST_PROTOCOL}, got {version}");
        Err(self.scan.malformed(problem))
    }

    /// A frame states how many bytes belong together, which is irrelevant in memory.
    fn check_frame(&mut self) -> Result<(), PickleError> {
        let length = self.scan.unsigned(8)?;
        let left = self.scan.left();
        if length <= left as u64 {
            return Ok(());
        }
        let problem = format!("truncated: a frame must have {length} bytes, got {left}");
        Err(self.scan.malformed(problem))
    }

    /// The value that an instruction pushes.
    fn make(&mut self, instruction: u8) -> Result<Node<'a>, PickleError> {
        Ok(match instruction {
            b']' => Node::List(Vec::new()),
            b')' => Node::Tuple(Vec::new()),
            b'}' => Node::Dict(Vec::new()),
            b'l' => Node::List(self.pop_to_mark()?),
            b't' => Node::Tuple(self.pop_to_mark()?),
            b'd' => {
                let items = self.pop_to_mark()?;
                Node::Dict(self.pairs(&items)?)
            }
            0x85..=0x87 => {
                let mut items = Vec::with_capacity(3);
                for _ in 0x85..=instruction {
                    items.push(self.pop()?);
                }
                items.reverse();
                Node::Tuple(items)
            }
            0x8f => Node::Set,
            0x91 => {
                drop(self.pop_to_mark()?);
                Node::Set
            }
            b'Q' if self.persistent => Node::Persistent(self.pop()?),
            b'c' => self.global_lines()?,
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let (module, name) = (self.value(module).as_str(), self.value(name).as_str());
                let (Some(module), Some(name)) = (module, name) else {
                    return Err(self.scan.malformed("a name must be a string"));
                };
                Node::Global(globals::find(module, name)?)
            }
            _ => return self.literal(instruction),
        })
    }

    /// The value that an instruction pushes, which is stated with it.
    fn literal(&mut self, instruction: u8) -> Result<Node<'a>, PickleError> {
        let scan = &mut self.scan;
        Ok(match instruction {
            b'N' => Node::None,
            0x88 => Node::Bool(true),
            0x89 => Node::Bool(false),
            b'I' => match scan.line()? {
                b"00" => Node::Bool(false),
                b"01" => Node::Bool(true),
                digits => Node::Int(scan.number(digits)?),
            },
            b'L' => Node::Int(scan.number_line()?),
            b'J' => Node::Int(scan.signed(4)?),
            b'K' => Node::Int(scan.unsigned(1)?.cast_signed()),
            b'M' => Node::Int(scan.unsigned(2)?.cast_signed()),
            0x8a => {
                let width = scan.unsigned(1)?;
                Node::Int(scan.signed(width)?)
            }
            0x8b => {
                let width = scan.unsigned(4)?;
                Node::Int(scan.signed(width)?)
            }
            b'F' => Node::Float(scan.number_line()?),
            b'G' => {
                // The only big-endian number.
                let bits = scan.unsigned(8)?.swap_bytes();
                Node::Float(f64::from_bits(bits))
            }
            b'V' => Node::Text(Cow::Owned(scan.escaped_text_line()?)),
            b'X' => Node::Text(scan.counted_text(4)?),
            0x8c => Node::Text(scan.counted_text(1)?),
            0x8d => Node::Text(scan.counted_text(8)?),
            b'S' => Node::Bytes(Cow::Owned(scan.quoted_line()?)),
            b'U' | b'C' => Node::Bytes(Cow::Borrowed(scan.counted(1)?)),
            b'T' | b'B' => Node::Bytes(Cow::Borrowed(scan.counted(4)?)),
            0x8e | 0x96 => Node::Bytes(Cow::Borrowed(scan.counted(8)?)),
            found => return Err(PickleError::Instruction { at: scan.instruction, found }),
        })
    }

    /// The items of an argument tuple. Copying only short ones prevents repeated calls with a long
    /// one from taking time.
    pub(super) fn arguments(&self, tuple: Id) -> Result<Vec<Id>, PickleError> {
        match self.value(tuple).node() {
            Node::Tuple(args) if args.len() <= MAX_ARGUMENTS => Ok(args.clone()),
            Node::Tuple(args) => {
                Err(self.scan.malformed(format!("too many arguments: {}", args.len())))
            }
            _ => {
                let kind = self.value(tuple).kind();
                Err(self.scan.malformed(format!("arguments must be a tuple, got {kind}")))
            }
        }
    }

    fn global_lines(&mut self) -> Result<Node<'a>, PickleError> {
        let (module, name) = (self.scan.text_line()?, self.scan.text_line()?);
        globals::find(module, name).map(Node::Global)
    }

    fn push_called(&mut self, callee: Id, args: &[Id]) -> Result<(), PickleError> {
        let node = self.call(callee, args)?;
        self.push(node);
        Ok(())
    }

    /// Stores the top of the stack in the memo, or pushes a memo entry.
    fn memo(&mut self, instruction: u8) -> Result<(), PickleError> {
        let key = match instruction {
            b'p' | b'g' => self.scan.number_line()?,
            b'q' | b'h' => self.scan.unsigned(1)?,
            b'r' | b'j' => self.scan.unsigned(4)?,
            _ => self.memo.len() as u64,
        };
        if matches!(instruction, b'g' | b'h' | b'j') {
            let held = self.memo.get(&key).copied();
            let problem = || format!("memo {key} is used before it is stored");
            self.stack.push(held.ok_or_else(|| self.scan.malformed(problem()))?);
        } else {
            let top = self.top()?;
            self.memo.insert(key, top);
        }
        Ok(())
    }

    /// Appends the values above the mark to the list or dict below it.
    fn fill(&mut self, instruction: u8) -> Result<(), PickleError> {
        let items = match instruction {
            b'a' => vec![self.pop()?],
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                vec![key, value]
            }
            _ => self.pop_to_mark()?,
        };
        let Id(into) = self.top()?;
        if matches!(instruction, b'a' | b'e') {
            if let Node::List(list) = &mut self.nodes[into as usize] {
                list.extend(items);
                return Ok(());
            }
        } else {
            let pairs = self.pairs(&items)?;
            if let Node::Dict(entries) = &mut self.nodes[into as usize] {
                entries.extend(pairs);
                return Ok(());
            }
        }
        let wanted = if matches!(instruction, b'a' | b'e') { "a list" } else { "a dict" };
        let found = self.value(Id(into)).kind();
        Err(self.scan.malformed(format!("must append to {wanted}, got {found}")))
    }

    fn pairs(&self, items: &[Id]) -> Result<Vec<(Id, Id)>, PickleError> {
        let (pairs, rest) = items.as_chunks::<2>();
        if rest.is_empty() {
            Ok(pairs.iter().map(|&[key, value]| (key, value)).collect())
        } else {
            Err(self.scan.malformed("dict key without a value"))
        }
    }

    pub(super) fn value(&self, id: Id) -> Value<'_> {
        Value::new(&self.nodes, id)
    }

    pub(super) fn replace(&mut self, id: Id, node: Node<'a>) {
        self.nodes[id.0 as usize] = node;
    }

    /// Counts bytes that are about to be copied.
    pub(super) fn count_copy(&mut self, bytes: usize) -> Result<(), PickleError> {
        self.copied = self.copied.saturating_add(bytes);
        if self.copied > self.most_copied {
            return Err(PickleError::TooMany { what: "decoded bytes", most: self.most_copied });
        }
        Ok(())
    }

    fn push(&mut self, node: Node<'a>) {
        // The limit of instructions keeps the index far below 32 bits.
        let id = Id(self.nodes.len() as u32);
        self.nodes.push(node);
        self.stack.push(id);
    }

    /// Pops the top of the stack; values below the last mark are out of reach.
    fn pop(&mut self) -> Result<Id, PickleError> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    fn top(&self) -> Result<Id, PickleError> {
        let reach = self.marks.last().copied().unwrap_or(0);
        let top = self.stack[reach..].last().copied();
        top.ok_or_else(|| self.scan.malformed("stack underflow"))
    }

    fn pop_to_mark(&mut self) -> Result<Vec<Id>, PickleError> {
        let mark = self.marks.pop();
        let mark = mark.ok_or_else(|| self.scan.malformed("missing mark"))?;
        Ok(self.stack.drain(mark..).collect())
    }

    /// Drops the top of the stack, which may be a mark.
    fn discard_one(&mut self) -> Result<(), PickleError> {
        if self.marks.last() == Some(&self.stack.len()) {
            self.marks.pop();
            return Ok(());
        }
        self.pop().map(drop)
    }
}
