// foot.geo, in millimetres
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 10, 20};    // the pad
Cylinder(2) = {0, 0, 10, 0, 0, 15, 8};    // the stem
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("rubber") = {1};
Physical Volume("steel") = {2};
Physical Surface("contact") = Surface In BoundingBox{-21, -21, -1, 21, 21, 1};
Physical Surface("held end") = Surface In BoundingBox{-9, -9, 24, 9, 9, 26};
Mesh.MeshSizeMax = 6;
