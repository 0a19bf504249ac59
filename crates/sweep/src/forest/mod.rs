//! Forests: the trees of one scene as variants of a sweep, and the scene that comes of it. Trees that do not break stay as they
//! are, instances of meshes that they share with others; those that break are replaced by their pieces.

mod compose;
mod pattern;

use crate::error::SweepError;
use crate::making::Trouble;
use greenstick::files;
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Scene};
use greenstick::session::NodeRole;
use greenstick::wood::noise;
use greenstick::{BreakSession, Broken, RequestFile};
use pattern::Patterns;
use std::path::{Path, PathBuf};

/// Names of trees where a sweep says nothing of them.
const NODES: &str = "Tree_*";
/// What numbers are drawn for, in the hash that draws them: which trees break, and the seed of each.
const CHOICE: i64 = 0x4652;
const SEED: i64 = 0x4653;

/// Which scene is a forest, and which of its trees break.
#[derive(Debug, Clone)]
pub struct ForestRequest<'a> {
    /// The file of the scene.
    pub path: &'a Path,
    /// Unit of length in it, where its format has none.
    pub unit: Option<LengthUnit>,
    /// Patterns of the names of trees; `None` for `Tree_*`.
    pub nodes: Option<&'a str>,
    /// Patterns of the names of those that may break; `None` for all.
    pub only: Option<&'a str>,
    /// The share of these that break.
    pub share: f64,
    /// Seed of the choice.
    pub seed: u64,
}

/// A tree of a forest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tree {
    /// The name of its node.
    pub name: String,
    /// Whether it is to break.
    pub breaks: bool,
    /// Its node, and those that it carries.
    nodes: Vec<usize>,
}

/// A scene with trees.
#[derive(Debug)]
pub struct Forest {
    scene: Scene,
    trees: Vec<Tree>,
}

impl Forest {
    /// Reads a forest, and finds its trees.
    ///
    /// # Errors
    /// [`SweepError`] where it cannot be read, or no node has such a name.
    pub fn load(request: &ForestRequest) -> Result<Self, SweepError> {
        let mut scene = files::read(request.path, request.unit)?;
        files::embed_images(&mut scene, request.path);
        let wrong = |problem: String| SweepError::Forest {
            path: Some(request.path.to_owned()),
            problem,
        };
        let nodes = request.nodes.unwrap_or(NODES);
        let mut trees = trees(&scene, &Patterns::new(nodes));
        if trees.is_empty() {
            let names = scene
                .nodes
                .iter()
                .take(3)
                .map(|n| format!("\"{}\"", n.name));
            let names: Vec<String> = names.collect();
            return Err(wrong(format!(
                "none of its {} nodes with a mesh has a name like \"{nodes}\", the first are {}; expected the names of trees in nodes",
                scene.nodes.len(),
                names.join(", ")
            )));
        }
        choose(&mut trees, request).map_err(wrong)?;
        Ok(Forest { scene, trees })
    }

    /// Its trees, in the order of their nodes.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// How many of them are to break.
    pub fn breaking(&self) -> u64 {
        self.trees.iter().filter(|tree| tree.breaks).count() as u64
    }

    /// How many trees before one are to break; `None` unless it is to break itself.
    pub(crate) fn place_among_breaking(&self, tree: u64) -> Option<u64> {
        let (before, rest) = self.trees.split_at_checked(tree as usize)?;
        let before = before.iter().filter(|tree| tree.breaks).count();
        rest.first()?.breaks.then_some(before as u64)
    }

    /// The seed of a tree's break, where seeds do not vary: trees of one mesh break differently.
    pub(crate) fn seed(&self, base: u64, tree: u64) -> u64 {
        noise::hash(base, SEED, tree as i64, 0) >> 32
    }

    /// Breaks a tree. It stands at the origin meanwhile, so that where it stands in the forest costs no precision. The pieces have
    /// its name before theirs.
    pub(crate) fn broken(
        &self,
        tree: &Tree,
        (file, textures): (&RequestFile, bool),
        context: &Context,
    ) -> Result<Broken, Trouble> {
        let mut scene = compose::part(&self.scene, &tree.nodes);
        let origin = self.scene.nodes[tree.nodes[0]].transform.translation;
        for node in &mut scene.nodes {
            node.transform.translation -= origin;
        }
        let mut request = file.request();
        if !textures {
            request.texture_width = 0;
        }
        let mut broken = BreakSession::new(scene).broken(&request, context)?;
        for (node, role) in broken.scene.nodes.iter_mut().zip(&broken.roles) {
            if matches!(role, NodeRole::Piece(_) | NodeRole::Fuzz(_)) {
                node.name = format!("{}_{}", tree.name, node.name);
            }
        }
        let provenance = file.provenance(Some(&tree.name), None);
        broken.scene.metadata = provenance.metadata();
        Ok(broken)
    }

    /// Returns the scene with the pieces of the trees that were broken in their place. `pieces` has the file of each of these, in
    /// the order of trees.
    pub(crate) fn with_pieces(
        &self,
        pieces: &[(usize, PathBuf)],
        context: &Context,
    ) -> Result<Scene, SweepError> {
        let gone = pieces.iter().flat_map(|(tree, _)| &self.trees[*tree].nodes);
        let mut stays = vec![true; self.scene.nodes.len()];
        gone.for_each(|&node| stays[node] = false);
        let mut number = Vec::with_capacity(stays.len());
        let mut count = 0;
        for stays in &stays {
            number.push(stays.then_some(count));
            count += usize::from(*stays);
        }
        let whole = &self.scene;
        let mut scene = Scene {
            nodes: Vec::with_capacity(count),
            ..whole.clone()
        };
        for (node, _) in whole.nodes.iter().zip(&stays).filter(|n| *n.1) {
            let mut node = node.clone();
            node.parent = node.parent.and_then(|parent| number[parent]);
            scene.nodes.push(node);
        }
        for (at, (tree, path)) in pieces.iter().enumerate() {
            context.item(at, pieces.len()).report(0.0)?;
            let root = &whole.nodes[self.trees[*tree].nodes[0]];
            let mut broken = files::read(path, None)?;
            for node in &mut broken.nodes {
                node.transform.translation += root.transform.translation;
            }
            let parent = root.parent.and_then(|parent| number[parent]);
            compose::append(&mut scene, broken, parent);
        }
        Ok(scene)
    }
}

/// Finds the trees of a scene: nodes of such names, each with all that it carries. What a tree carries is no tree of its own.
fn trees(scene: &Scene, names: &Patterns) -> Vec<Tree> {
    let count = scene.nodes.len();
    let mut roots: Vec<Option<usize>> = Vec::with_capacity(count);
    for node in 0..count {
        // The node farthest up that has such a name; no more steps than there are nodes, whatever their parents.
        let above = std::iter::successors(Some(node), |&n| scene.nodes[n].parent);
        let above = above
            .take(count)
            .filter(|&n| names.matches(&scene.nodes[n].name));
        roots.push(above.last());
    }
    let is_root = |node: usize| roots[node] == Some(node);
    let mut trees: Vec<Tree> = Vec::new();
    let mut of_root = vec![usize::MAX; count];
    for node in (0..count).filter(|&n| is_root(n)) {
        of_root[node] = trees.len();
        trees.push(Tree {
            name: scene.nodes[node].name.clone(),
            breaks: true,
            nodes: vec![node],
        });
    }
    for node in (0..count).filter(|&n| !is_root(n)) {
        if let Some(root) = roots[node] {
            trees[of_root[root]].nodes.push(node);
        }
    }
    trees
}

/// Chooses the trees that break: of those that are named, a share.
fn choose(trees: &mut [Tree], request: &ForestRequest) -> Result<(), String> {
    if let Some(only) = request.only {
        let names = Patterns::new(only);
        trees
            .iter_mut()
            .for_each(|t| t.breaks = names.matches(&t.name));
        if !trees.iter().any(|tree| tree.breaks) {
            return Err(format!(
                "none of its {} trees has a name like \"{only}\"; expected names of trees that break in only",
                trees.len()
            ));
        }
    }
    let mut order: Vec<usize> = (0..trees.len()).filter(|&t| trees[t].breaks).collect();
    order.sort_by_key(|&tree| (noise::hash(request.seed, CHOICE, tree as i64, 0), tree));
    let wanted = (request.share * order.len() as f64).round() as usize;
    for &tree in &order[wanted.min(order.len())..] {
        trees[tree].breaks = false;
    }
    Ok(())
}
