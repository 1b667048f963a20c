//! Gmsh files that are read, refused, damaged and shuffled.

mod broken;
mod mutated;
mod samples;

const FOOT_41: &[u8] = include_bytes!("../../../meshes/foot_41.msh");
const FOOT_41_BINARY: &[u8] = include_bytes!("../../../meshes/foot_41_binary.msh");
const FOOT_22: &[u8] = include_bytes!("../../../meshes/foot_22.msh");
const BRACKET_41: &[u8] = include_bytes!("../../../meshes/bracket_41.msh");
const BRACKET_22: &[u8] = include_bytes!("../../../meshes/bracket_22.msh");

/// Two tetrahedra on the common triangle 1 2 3, with tags that leave gaps and an unused node.
const PAIR_22: &str = r#"$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "bottom"
2 2 "side"
3 7 "body"
$EndPhysicalNames
$Nodes
6
30 0 1 0
1 0 0 0
20 1 0 0
4 0 0 1
50 0 0 -1
99 7 7 7
$EndNodes
$Elements
5
1 15 2 0 1 1
2 2 2 1 1 1 30 50
3 2 2 2 1 1 4 30
4 4 2 7 1 1 20 30 4
5 4 2 7 1 1 30 20 50
$EndElements
"#;

/// The same in the other format, with parametric coordinates at some nodes.
const PAIR_41: &str = r#"$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "bottom"
2 2 "side"
3 7 "body"
$EndPhysicalNames
$Entities
1 0 2 1
1 0 0 0 0
1 0 0 -1 0 1 0 1 1 0
2 0 0 0 0 1 1 1 -2 0
1 0 0 -1 1 1 1 1 7 2 1 -2
$EndEntities
$Nodes
2 6 1 99
2 1 0 3
30
1
20
0 1 0
0 0 0
1 0 0
2 2 1 3
4
50
99
0 0 1 .5 .5
0 0 -1 .5 .5
7 7 7 .5 .5
$EndNodes
$Elements
4 5 1 5
0 1 15 1
1 1
2 1 2 1
2 1 30 50
2 2 2 1
3 1 4 30
3 1 4 2
4 1 20 30 4
5 1 30 20 50
$EndElements
"#;
