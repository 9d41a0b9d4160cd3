// $fn reaches the modules that are called, and children.
$fn = 12;
module knob(r) { cylinder(h = 4, r = r); translate([0, 0, 4]) sphere(r); }
module smooth() { $fn = 48; children(); knob(3); }

knob(5);
translate([15, 0, 0]) knob(5, $fn = 36);
translate([30, 0, 0]) smooth() translate([0, 10, 0]) knob(4);
translate([45, 0, 0], $fn = 6) cylinder(r = 5, h = 3);
