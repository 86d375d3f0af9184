use super::*;
use crate::mesh::Lattice;
use proptest::prelude::*;

fn mesh_of(cells: [usize; 3], degree: usize, solid: impl Fn([usize; 3]) -> bool) -> CoarseMesh {
    let lattice = Lattice::new(cells);
    let void: Vec<bool> = (0..lattice.cell_count()).map(|c| !solid(lattice.cell_position(Cell(c)))).collect();
    CoarseMesh::new(&void, &Partition::new(lattice, degree).unwrap())
}

/// Parts and ties by their definitions, on sets of fine nodes; vertices as sets of (cell, first fine cell, corner).
fn brute_force(void: &[bool], partition: &Partition) -> Vec<Vec<(usize, usize, usize)>> {
    let fine = partition.fine();
    let mut parts: Vec<(usize, Vec<usize>, Vec<usize>)> = Vec::new();
    for cell in (0..partition.coarse().cell_count()).map(CoarseCell) {
        let solid: Vec<Cell> = partition.fine_cells(cell).filter(|c| !void[c.0]).collect();
        let mut label: Vec<usize> = (0..solid.len()).collect();
        for _ in 0..solid.len() {
            for (a, b) in (0..solid.len()).flat_map(|a| (0..solid.len()).map(move |b| (a, b))) {
                let corners = fine.corners(solid[b]);
                if fine.corners(solid[a]).iter().any(|n| corners.contains(n)) {
                    label[a] = label[a].min(label[b]);
                }
            }
        }
        for first in (0..solid.len()).filter(|&i| label[i] == i) {
            let own: Vec<usize> = (0..solid.len()).filter(|&i| label[i] == first).map(|i| solid[i].0).collect();
            let nodes = own.iter().flat_map(|c| fine.corners(Cell(*c)).map(|n| n.0)).collect();
            parts.push((cell.0, own, nodes));
        }
    }
    let mut vertices = Vec::new();
    for node in (0..partition.coarse().node_count()).map(CoarseNode) {
        let corner_of = |cell: usize| partition.corners(CoarseCell(cell)).iter().position(|n| *n == node);
        let slots: Vec<usize> = (0..parts.len()).filter(|&p| corner_of(parts[p].0).is_some()).collect();
        let mut label: Vec<usize> = (0..slots.len()).collect();
        for _ in 0..slots.len() {
            for (a, b) in (0..slots.len()).flat_map(|a| (0..slots.len()).map(move |b| (a, b))) {
                let (one, other) = (&parts[slots[a]], &parts[slots[b]]);
                if one.0 != other.0 && one.2.iter().any(|n| other.2.contains(n)) {
                    label[a] = label[a].min(label[b]);
                }
            }
        }
        for first in (0..slots.len()).filter(|&i| label[i] == i) {
            let tied = (0..slots.len()).filter(|&i| label[i] == first).map(|i| &parts[slots[i]]);
            vertices.push(tied.map(|p| (p.0, p.1[0], corner_of(p.0).unwrap())).collect());
        }
    }
    vertices
}

/// The same description of the mesh's vertices.
fn described(mesh: &CoarseMesh) -> Vec<Vec<(usize, usize, usize)>> {
    let mut vertices = vec![Vec::new(); mesh.vertices().len()];
    for (element, corners) in mesh.elements().iter().zip(mesh.corners()) {
        let (_, first) = mesh.fine_cells(*element).next().unwrap();
        for (corner, vertex) in corners.iter().enumerate() {
            vertices[*vertex as usize].push((element.cell.0, first.0, corner));
        }
    }
    vertices
}

#[test]
fn a_solid_body_is_a_lattice() {
    let mesh = mesh_of([6, 3, 3], 3, |_| true);
    assert!(mesh.is_lattice());
    assert_eq!((mesh.elements().len(), mesh.vertices().len()), (2, 12));
    assert_eq!(mesh.corners()[1], [1, 2, 4, 5, 7, 8, 10, 11]);
}

#[test]
fn a_slit_half_way_doubles_the_vertices_beside_it_and_none_at_its_end() {
    // Two coarse cells along x; the slit z = 1 runs through the first and stops at their common face.
    let mesh = mesh_of([6, 3, 3], 3, |[i, _, k]| k != 1 || i >= 3);
    assert_eq!(mesh.elements(), [(0, 0), (0, 1), (1, 0)].map(|(c, part)| CellPart { cell: CoarseCell(c), part }));
    let copies: Vec<usize> = (0..12).map(|n| mesh.vertices_at(CoarseNode(n)).len()).collect();
    assert_eq!(copies, [2, 1, 1, 2, 1, 1, 2, 1, 1, 2, 1, 1]);
    // Through the second cell as well, all twelve nodes are doubled.
    assert_eq!(mesh_of([6, 3, 3], 3, |[_, _, k]| k != 1).vertices().len(), 24);
}

#[test]
fn material_on_both_sides_of_a_gap_is_not_tied_over_it() {
    let mesh = mesh_of([4, 2, 2], 2, |[i, _, _]| i == 0 || i == 3);
    assert_eq!((mesh.elements().len(), mesh.vertices().len()), (2, 16));
    // Ties go through a third part: a bridge in the next row of cells joins the two.
    let bridged = mesh_of([4, 4, 2], 2, |[i, j, _]| i == 0 || i == 3 || j == 2);
    let copies: Vec<usize> = (0..18).map(|n| bridged.vertices_at(CoarseNode(n)).len()).collect();
    assert_eq!(copies, [1, 2, 1, 1, 1, 1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 1, 1, 1]);
}

#[test]
fn an_island_has_vertices_of_its_own() {
    let mesh = mesh_of([5; 3], 5, |at| at.iter().any(|x| *x == 0 || *x == 4) || at == [2, 2, 2]);
    assert_eq!((mesh.elements().len(), mesh.vertices().len()), (2, 16));
    assert_eq!(mesh.fine_cells(mesh.elements()[1]).map(|(_, c)| c).collect::<Vec<_>>(), [Cell(62)]);
    assert_eq!(mesh.fine_nodes(mesh.elements()[1]).len(), 8);
}

#[test]
fn nodes_that_a_neighbour_touches_are_tied_where_it_shares_a_vertex() {
    let tied_of_first = |solid: fn([usize; 3]) -> bool| {
        let mesh = mesh_of([6, 3, 3], 3, solid);
        let nodes = |marks: Vec<bool>| -> Vec<usize> { (0..64).filter(|n| marks[*n]).collect() };
        let (own, tied) = (nodes(mesh.touched_nodes(mesh.elements()[0])), nodes(mesh.tied_nodes(mesh.elements()[0])));
        assert_eq!(own, (0..32).collect::<Vec<_>>());
        tied[own.len()..].to_vec()
    };
    // A layer beside a full cell, whose nodes at x = 3 move along; beside a layer that it does not meet; and below another part of its own cell.
    assert_eq!(tied_of_first(|[i, _, k]| i >= 3 || k == 0), [35, 39, 43, 47, 51, 55, 59, 63]);
    assert_eq!(tied_of_first(|[i, _, k]| if i < 3 { k == 0 } else { k == 2 }), []);
    assert_eq!(tied_of_first(|[i, _, k]| i < 3 && k != 1), []);
}

#[test]
fn an_unsplit_mesh_has_one_element_per_cell_and_one_vertex_per_node() {
    let partition = Partition::new(Lattice::new([6, 3, 3]), 3).unwrap();
    let void: Vec<bool> = (0..54).map(|c| c / 6 / 3 == 1 || c % 6 > 2).collect();
    let mesh = CoarseMesh::unsplit(&void, &partition);
    assert!(mesh.is_lattice());
    assert_eq!((mesh.elements().len(), mesh.vertices().len()), (1, 8));
    assert_eq!(CoarseMesh::new(&void, &partition).vertices().len(), 16);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn vertices_are_those_of_the_definition(
        coarse in prop::array::uniform3(1..4usize),
        degree in 1..4usize,
        share in 0.0..1.0f64,
        seeds in prop::collection::vec(0.0..1.0f64, 729),
    ) {
        let partition = Partition::new(Lattice::new(coarse.map(|n| n * degree)), degree).unwrap();
        let void: Vec<bool> = seeds[..partition.fine().cell_count()].iter().map(|s| *s < share).collect();
        let mesh = CoarseMesh::new(&void, &partition);
        prop_assert_eq!(described(&mesh), brute_force(&void, &partition));
        prop_assert!(mesh.elements().is_sorted() && mesh.vertices().is_sorted());
        for cell in (0..void.len()).map(Cell) {
            let holders = |e: &CellPart| mesh.fine_cells(*e).any(|(_, c)| c == cell);
            prop_assert_eq!(mesh.elements().iter().position(holders), mesh.element_at(cell));
            prop_assert_eq!(mesh.element_at(cell).is_none(), void[cell.0]);
        }
    }

    #[test]
    fn an_update_after_edits_is_the_mesh_of_the_edited_body(
        coarse in prop::array::uniform3(1..5usize),
        degree in 1..4usize,
        split in any::<bool>(),
        edits in prop::collection::vec((prop::array::uniform3(0..12usize), 0..4usize, any::<bool>()), 1..8),
        seeds in prop::collection::vec(any::<u8>(), 1728),
    ) {
        let partition = Partition::new(Lattice::new(coarse.map(|n| n * degree)), degree).unwrap();
        let fine = partition.fine();
        let mut void: Vec<bool> = seeds[..fine.cell_count()].iter().map(|s| *s < 60).collect();
        let build = |void: &[bool]| CoarseMesh::build(void, &partition, split);
        let mut mesh = build(&void);
        for (at, reach, value) in edits {
            let at: [usize; 3] = std::array::from_fn(|a| at[a] % fine.cells[a]);
            let mut changed = Vec::new();
            for c in 0..void.len() {
                let position = fine.cell_position(Cell(c));
                if void[c] != value && (0..3).all(|a| position[a].abs_diff(at[a]) <= reach) {
                    void[c] = value;
                    changed.push(CoarseCell(partition.coarse().cell(position.map(|x| x / degree)).0));
                }
            }
            changed.sort();
            changed.dedup();
            mesh.update(&void, &changed);
            prop_assert_eq!(&mesh, &build(&void));
        }
    }

    #[test]
    fn identical_meshes_carry_a_state_bit_for_bit(
        degree in 1..4usize,
        share in 0.0..1.0f64,
        seeds in prop::collection::vec(0.0..1.0f64, 216),
    ) {
        let partition = Partition::new(Lattice::new([2 * degree; 3]), degree).unwrap();
        let void: Vec<bool> = seeds[..partition.fine().cell_count()].iter().map(|s| *s < share).collect();
        let mesh = CoarseMesh::new(&void, &partition);
        let state: Vec<f64> = (0..3 * mesh.vertices().len()).map(|i| (i as f64).sin()).collect();
        prop_assert_eq!(mesh.carry(&mesh, &state), state);
    }
}

#[test]
fn a_split_gives_both_copies_the_old_state_and_healing_takes_it_from_the_larger_share() {
    let (solid, slit) = (mesh_of([3; 3], 3, |_| true), mesh_of([3; 3], 3, |[_, _, k]| k != 1));
    let state: Vec<f64> = (0..24).map(f64::from).collect();
    let split = slit.carry(&solid, &state);
    for (vertex, value) in slit.vertices().iter().zip(split.chunks_exact(3)) {
        assert_eq!(value, &state[3 * vertex.node.0..][..3]);
    }
    let of_two: Vec<f64> = slit.vertices().iter().flat_map(|v| [f64::from(v.copy); 3]).collect();
    // Both parts are one layer of nine cells, so the first copy wins; with two layers the second part is the larger.
    assert!(solid.carry(&slit, &of_two).iter().all(|u| *u == 0.0));
    let thick = mesh_of([4; 3], 4, |[_, _, k]| k != 1);
    let of_two: Vec<f64> = thick.vertices().iter().flat_map(|v| [f64::from(v.copy); 3]).collect();
    assert!(mesh_of([4; 3], 4, |_| true).carry(&thick, &of_two).iter().all(|u| *u == 1.0));
}

#[test]
fn new_material_takes_the_mean_of_what_is_known_around_it_cell_by_cell() {
    let row = |solid: usize| mesh_of([4, 1, 1], 1, move |[i, _, _]| i < solid);
    let state: Vec<f64> =
        row(1).vertices().iter().flat_map(|v| [if v.node.0 % 5 == 1 { 6.0 } else { 2.0 }; 3]).collect();
    let carried = row(3).carry(&row(1), &state);
    for (vertex, value) in row(3).vertices().iter().zip(carried.chunks_exact(3)) {
        // Vertices at x = 2 see the four known ones at x = 1 only, those at x = 3 the ones at x = 2.
        assert_eq!(value, [if vertex.node.0 % 5 == 0 { 2.0 } else { 6.0 }; 3], "{vertex:?}");
    }
    // Far from everything nothing is known.
    let far = mesh_of([4, 1, 1], 1, |[i, _, _]| i == 3).carry(&row(1), &state);
    assert_eq!(far, vec![0.0; 24]);
}
