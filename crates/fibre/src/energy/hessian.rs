//! Hessians of single elements: edges, vertices with bending, and bonds.

/// Which Hessian is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HessianKind {
    /// The exact second derivatives. For bending and twist in material frames it is the Gauss–Newton part, which is all of it
    /// at rest.
    Exact,
    /// The Gauss–Newton part, from first derivatives of strains. It is never negative, so that it can always be factored.
    GaussNewton,
}

/// Largest number of degrees of freedom of an element: three vertices and two angles.
pub(crate) const MAX_ELEMENT_DOFS: usize = 11;

/// The Hessian of one element over its degrees of freedom: number 3v + axis for vertex v, and 3n + j for the angle of edge
/// j, of n vertices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ElementHessian {
    /// Number of entries used below.
    pub count: usize,
    /// Degrees of freedom.
    pub dofs: [u32; MAX_ELEMENT_DOFS],
    /// Symmetric matrix of second derivatives.
    pub matrix: [[f64; MAX_ELEMENT_DOFS]; MAX_ELEMENT_DOFS],
}
