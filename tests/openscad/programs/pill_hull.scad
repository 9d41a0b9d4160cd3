// Hulls of solids and of flat shapes.
$fs = 0.5;
$fa = 6;
hull() {
    sphere(d = 6);
    translate([20, 0, 0]) cylinder(h = 8, r1 = 5, r2 = 1, center = true);
}
translate([0, 20, 0]) linear_extrude(3) hull() {
    circle(4);
    translate([15, 5]) square([4, 6], center = true);
}
