// A vase: a twisted and tapered star, hollowed.
height = 40;
module star(n, outer, inner)
    polygon([for (i = [0 : 2 * n - 1]) let (r = i % 2 == 0 ? outer : inner, a = 180 * i / n) [r * cos(a), r * sin(a)]]);

difference() {
    linear_extrude(height, twist = 120, slices = 40, scale = 1.4) star(6, 12, 9);
    translate([0, 0, 2]) linear_extrude(height, twist = 120, slices = 40, scale = 1.4) star(6, 10, 7);
}
translate([40, 0, 0]) linear_extrude(30, twist = -90, $fn = 60) square([12, 6], center = true);
