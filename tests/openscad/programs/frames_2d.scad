// Flat modelling: offsets, differences, holes by paths, Minkowski sums.
$fn = 64;
module ring(r, w) difference() { circle(r); circle(r - w); }
module frame(w = 2) difference() { offset(r = w) children(); children(); }

linear_extrude(4) frame(3) square([20, 12], center = true);
translate([30, 0, 0]) linear_extrude(3) ring(8, 2);
translate([0, 25, 0]) linear_extrude(2)
    polygon([[0, 0], [20, 0], [20, 10], [0, 10], [4, 3], [16, 3], [16, 7], [4, 7]], paths = [[0, 1, 2, 3], [4, 5, 6, 7]]);
translate([30, 25, 0]) linear_extrude(2) minkowski() { square([10, 4]); circle(2); }
translate([60, 0, 0]) linear_extrude(2) offset(delta = -1) difference() { square(16); translate([4, 4]) square(6); }
translate([60, 25, 0]) linear_extrude(2) intersection() { circle(8); translate([0, -8]) square(16); }
