// Every movement: multmatrix, mirror, scale, resize, both forms of rotate.
module ell() { cube([6, 2, 2]); cube([2, 5, 2]); }

ell();
translate([0, 10, 0]) rotate([30, 40, 50]) ell();
translate([0, 20, 0]) rotate(a = 45, v = [1, 1, 0]) ell();
translate([15, 0, 0]) mirror([1, 1, 0]) ell();
translate([15, 10]) scale([1, 2, 0.5]) ell();
translate([15, 25, 0]) multmatrix([[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0.2, 1, 3], [0, 0, 0, 1]]) ell();
translate([30, 0, 0]) resize([12, 4, 0]) ell();
translate([30, 15, 0]) linear_extrude(2) mirror([1, 0]) rotate(20) scale([2, 1]) translate([1, 1]) square([4, 2]);
