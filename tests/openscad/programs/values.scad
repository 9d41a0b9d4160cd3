// Values: strings, tests, conversions, lists in lists, let and each.
sizes = concat([4], [for (i = [1 : 3]) i * 2], [each [7, 8]]);
label = str("n", len(sizes), "-", true, "-", [1, 2.5]);
table = [[0, 2], [10, 6], [20, 3]];
v = [1, 2, 2];
m = [[1, 2], [3, 4]];
a = 5;
a = 7;

for (i = [0 : len(sizes) - 1]) translate([i * 10, 0, 0]) cube(sizes[i] / 2 + (i % 2 == 1 ? 1 : 0));
translate([0, 15, 0]) cube([len(label), lookup(5, table), norm(v)]);
translate([30, 15, 0]) cube([v * v, (m * [1, 1])[1], a]);
translate([50, 15, 0]) cube([abs(-3), round(2.5), pow(2, 2)]);
translate([60, 15, 0]) cube(undef == undef && !is_undef(v) ? max(v) : min([9, 8]));
translate([0, 30, 0]) let (w = floor(4.9), h = ceil(1.1)) cube([w, h, atan2(1, 1) / 9]);
translate([15, 30, 0]) cube([sqrt(16), sign(-2) + 4, cross([1, 0, 0], [0, 1, 0]).z * 2]);
