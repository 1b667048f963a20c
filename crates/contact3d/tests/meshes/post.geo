// A short round post with curved sides: tetrahedra of the second order. Lengths in m.
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.5, 1};
Mesh.MeshSizeMin = 0.5;
Mesh.MeshSizeMax = 0.5;
Mesh.ElementOrder = 2;
Physical Volume("steel") = {1};
foot() = Surface In BoundingBox{-1.1, -1.1, -0.1, 1.1, 1.1, 0.1};
top() = Surface In BoundingBox{-1.1, -1.1, 0.4, 1.1, 1.1, 0.6};
side() = Surface In BoundingBox{-1.1, -1.1, -0.1, 1.1, 1.1, 0.6};
side() -= foot();
side() -= top();
Physical Surface("foot") = {foot()};
Physical Surface("top") = {top()};
Physical Surface("side") = {side()};
