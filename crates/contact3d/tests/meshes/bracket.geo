// A box with a hole through it; the hole is named, the ends by number only. Lengths in m.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 3, 1, 1};
Cylinder(2) = {1.5, -1, 0.5, 0, 3, 0, 0.25};
BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Mesh.MeshSizeMin = 0.34;
Mesh.MeshSizeMax = 0.34;
eps = 1e-3;
bottom() = Surface In BoundingBox{-eps, -eps, -eps, 3+eps, 1+eps, eps};
left() = Surface In BoundingBox{-eps, -eps, -eps, eps, 1+eps, 1+eps};
right() = Surface In BoundingBox{3-eps, -eps, -eps, 3+eps, 1+eps, 1+eps};
hole() = Surface In BoundingBox{1.2, -eps, 0.2, 1.8, 1+eps, 0.8};
Physical Volume("body") = {1};
Physical Surface("contact") = {bottom()};
Physical Surface("hole") = {hole()};
Physical Surface(40) = {left()};
Physical Surface(41) = {right()};
