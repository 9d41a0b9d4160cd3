// Polyhedra: faces are clockwise seen from outside in OpenSCAD.
module pyramid(side, height) {
    h = side / 2;
    polyhedron(
        points = [[-h, -h, 0], [h, -h, 0], [h, h, 0], [-h, h, 0], [0, 0, height]],
        faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 3], [2, 1, 3]]
    );
}
pyramid(10, 12);
translate([15, 0, 0]) mirror([1, 0, 0]) pyramid(8, 6);
difference() {
    translate([-15, 0, 0]) pyramid(10, 10);
    translate([-20, -5, -1]) cube([5, 10, 20]);
}
