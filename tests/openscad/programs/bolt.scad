// A bolt with a hexagonal head, and its nut beside it.
diameter = 8;
length = 24;
tolerance = 0.2;

module hexagon(width, height) cylinder(d = width / cos(30), h = height, $fn = 6);
module shaft(d, h) {
    cylinder(d = d, h = h - 1, $fn = 48);
    translate([0, 0, h - 1]) cylinder(d1 = d, d2 = d - 2, h = 1, $fn = 48);
}
module bolt(d = diameter, l = length) {
    color("silver") hexagon(1.6 * d, 0.6 * d);
    color([0.6, 0.6, 0.65]) translate([0, 0, 0.6 * d - 0.01]) shaft(d, l);
}
module nut(d = diameter) difference() {
    hexagon(1.6 * d, 0.8 * d);
    translate([0, 0, -1]) cylinder(d = d + tolerance, h = d + 2, $fn = 48);
}
bolt();
translate([20, 0, 0]) color("gold", 0.9) nut();
translate([40, 0, 0]) { bolt(l = 12, d = 5); }
