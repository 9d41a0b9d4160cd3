// children() by number, in a loop, flat and solid.
module row(step) { for (i = [0 : $children - 1]) translate([i * step, 0, 0]) children(i); }
module twice(offset) { children(); translate(offset) children(); }
module raise(h) linear_extrude(h) children();

row(12) {
    cube(8);
    cylinder(h = 6, r = 4, $fn = 20);
    if (true) sphere(4, $fn = 20);
}
translate([0, 20, 0]) twice([0, 10, 0]) row(10) { cube([4, 4, 2]); cube([2, 2, 6]); }
translate([0, 45, 0]) raise(3) twice([12, 0]) circle(4, $fn = 12);
