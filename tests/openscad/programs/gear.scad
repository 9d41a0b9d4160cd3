// A spur gear by list comprehension.
teeth = 18;
module_size = 2;
bore = 6;

pitch = teeth * module_size / 2;
function polar(r, a) = r * [cos(a), sin(a)];
function tooth(i) =
    let (step = 360 / teeth, a = i * step)
    [polar(pitch - 1.25 * module_size, a - 0.30 * step), polar(pitch + module_size, a - 0.12 * step),
     polar(pitch + module_size, a + 0.12 * step), polar(pitch - 1.25 * module_size, a + 0.30 * step)];

points = [for (i = [0 : teeth - 1], p = tooth(i)) p];

difference() {
    linear_extrude(height = 8, convexity = 10) polygon(points);
    translate([0, 0, -1]) cylinder(d = bore, h = 10, $fn = 32);
    for (a = [0 : 60 : 300])
        rotate(a) translate([pitch / 2, 0, -1]) cylinder(r = 2, h = 10, $fn = 16);
}
