// intersection_for, nested loops, and a part that may be missing.
with_core = false;
levels = [[8, 0], [6, 4], [4, 8]];

intersection_for (a = [0 : 60 : 120]) rotate([0, 0, a]) cube([20, 12, 10], center = true);

translate([30, 0, 0]) for (level = levels) translate([0, 0, level[1]]) cylinder(r = level[0], h = 4, $fn = 6);

translate([60, 0, 0]) difference() {
    union() { for (x = [-1, 1], y = [-1, 1]) translate([x * 5, y * 5, 0]) cube(6, center = true); cube(8, center = true); }
    if (with_core) cylinder(r = 2, h = 20, center = true);
    cylinder(r = 1.5, h = 30, center = true, $fn = 24);
}
