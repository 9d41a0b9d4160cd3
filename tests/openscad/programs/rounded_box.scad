// A lidless box with rounded edges.
size = [40, 30, 15];
wall = 2;
radius = 3;
$fn = 24;

module rounded(size, r) {
    minkowski() {
        translate([r, r, r]) cube(size - [2 * r, 2 * r, 2 * r]);
        sphere(r);
    }
}

difference() {
    rounded(size, radius);
    translate([wall, wall, wall])
        cube([size.x - 2 * wall, size.y - 2 * wall, size.z]);
}
