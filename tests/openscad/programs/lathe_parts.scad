// Turned parts: whole, part of a turn, and an odd number of sides.
rotate_extrude($fn = 40) polygon([[2, 0], [8, 0], [8, 2], [4, 4], [4, 10], [2, 10]]);
translate([25, 0, 0]) rotate_extrude(angle = 120, $fn = 36) translate([6, 0]) circle(2, $fn = 12);
translate([0, 25, 0]) rotate_extrude(angle = -90, $fn = 16) translate([4, 0]) square([3, 5]);
translate([25, 25, 0]) difference() {
    rotate_extrude($fn = 5) translate([4, 0]) circle(2, $fn = 8);
    translate([0, -10, -5]) cube([20, 20, 10]);
}
