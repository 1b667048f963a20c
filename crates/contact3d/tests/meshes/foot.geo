// A round foot of two materials on a flat round contact face. Lengths in mm.
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 10, 20};
Cylinder(2) = {0, 0, 10, 0, 0, 15, 8};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Mesh.MeshSizeMin = 6;
Mesh.MeshSizeMax = 6;
Mesh.Algorithm = 6;
Physical Volume("rubber") = {1};
Physical Volume("steel") = {2};
bottom() = Surface In BoundingBox{-21, -21, -0.1, 21, 21, 0.1};
top() = Surface In BoundingBox{-21, -21, 24.9, 21, 21, 25.1};
Physical Surface("contact") = {bottom()};
Physical Surface("held end") = {top()};
