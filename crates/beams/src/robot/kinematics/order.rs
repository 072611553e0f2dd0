//! The order in which bodies and nodes of a robot follow from one another.

use crate::robot::Robot;
use crate::robot::model::{BodyPlace, NodePlace, RadiusOf};

/// A body or a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum Item {
    Body(usize),
    Node(usize),
}

/// Something that needs itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::robot) struct Circular {
    pub(in crate::robot) kind: &'static str,
    pub(in crate::robot) name: String,
    pub(in crate::robot) chain: String,
}

/// The order in which bodies and nodes follow from one another.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(in crate::robot) struct Order(pub(super) Vec<Item>);

/// Finds whether every body and node of a robot can be placed.
pub(in crate::robot) fn check_order(robot: &Robot) -> Result<(), Circular> {
    let bodies = (0..robot.bodies.len()).map(Item::Body);
    let nodes = (0..robot.nodes.len()).map(Item::Node);
    Order::of(robot, bodies.chain(nodes)).map(|_| ())
}

impl Order {
    /// The order that leads to the wanted items and to nothing else.
    pub(in crate::robot) fn of(
        robot: &Robot,
        wanted: impl Iterator<Item = Item>,
    ) -> Result<Self, Circular> {
        let mut search = Search {
            robot,
            body_state: vec![VisitState::New; robot.bodies.len()],
            node_state: vec![VisitState::New; robot.nodes.len()],
            path: Vec::new(),
            order: Vec::new(),
        };
        for item in wanted {
            search.visit(item)?;
        }
        Ok(Self(search.order))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum VisitState {
    New,
    Open,
    Done,
}

/// Depth-first search for the order.
struct Search<'a> {
    robot: &'a Robot,
    body_state: Vec<VisitState>,
    node_state: Vec<VisitState>,
    path: Vec<Item>,
    order: Vec<Item>,
}

impl Search<'_> {
    fn state(&mut self, item: Item) -> &mut VisitState {
        match item {
            Item::Body(body) => &mut self.body_state[body],
            Item::Node(node) => &mut self.node_state[node],
        }
    }

    /// Puts what an item needs, and then the item, into the order.
    ///
    /// The path is kept here and not in recursive calls: a chain of bodies may be longer than the thread's stack is deep.
    fn visit(&mut self, item: Item) -> Result<(), Circular> {
        let mut waiting = vec![vec![item]];
        while let Some(level) = waiting.last_mut() {
            let Some(next) = level.pop() else {
                // Everything the last item of the path needs is in the order.
                waiting.pop();
                if let Some(done) = self.path.pop() {
                    *self.state(done) = VisitState::Done;
                    self.order.push(done);
                }
                continue;
            };
            match *self.state(next) {
                VisitState::Done => {}
                VisitState::Open => return Err(self.circular(next)),
                VisitState::New => {
                    *self.state(next) = VisitState::Open;
                    self.path.push(next);
                    let mut needed = needs(self.robot, next);
                    needed.reverse();
                    waiting.push(needed);
                }
            }
        }
        Ok(())
    }

    fn circular(&self, item: Item) -> Circular {
        let start = self
            .path
            .iter()
            .position(|on_path| *on_path == item)
            .unwrap_or(0);
        let around = self.path[start..].iter().chain(std::iter::once(&item));
        let chain = around
            .map(|i| name(self.robot, *i))
            .collect::<Vec<_>>()
            .join(" needs ");
        let kind = match item {
            Item::Body(_) => "body",
            Item::Node(_) => "node",
        };
        Circular {
            kind,
            name: name(self.robot, item),
            chain,
        }
    }
}

fn name(robot: &Robot, item: Item) -> String {
    match item {
        Item::Body(body) => robot.bodies[body].name.clone(),
        Item::Node(node) => robot.nodes[node].name.to_string(),
    }
}

/// What must be placed before an item.
fn needs(robot: &Robot, item: Item) -> Vec<Item> {
    let plane_body = |plane: usize| Item::Body(robot.planes[plane].body);
    match item {
        Item::Body(body) => match &robot.bodies[body].place {
            BodyPlace::Ground => Vec::new(),
            BodyPlace::Turned { parent, origin, .. } | BodyPlace::Slid { parent, origin, .. } => {
                vec![Item::Body(*parent), Item::Node(*origin)]
            }
            BodyPlace::Along {
                nodes: [first, second],
                plane,
                ..
            } => {
                vec![Item::Node(*first), Item::Node(*second), plane_body(*plane)]
            }
        },
        Item::Node(node) => match &robot.nodes[node].place {
            NodePlace::Fixed { body, .. } => vec![Item::Body(*body)],
            NodePlace::Loop {
                centres,
                radii,
                plane,
                ..
            } => {
                let mut items = vec![
                    Item::Node(centres[0]),
                    Item::Node(centres[1]),
                    plane_body(*plane),
                ];
                for radius in radii {
                    if let RadiusOf::Distance([first, second]) = radius {
                        items.extend([Item::Node(*first), Item::Node(*second)]);
                    }
                }
                items
            }
        },
    }
}
