// A recursive module and recursive functions.
function total(v, i = 0) = i < len(v) ? v[i] + total(v, i + 1) : 0;
function fib(n) = n < 2 ? n : fib(n - 1) + fib(n - 2);

module branch(length, level) {
    cylinder(h = length, r1 = length / 8, r2 = length / 12, $fn = 8);
    if (level > 0)
        translate([0, 0, length])
            for (a = [0, 120, 240])
                rotate([35, 0, a]) branch(length * 0.7, level - 1);
}
branch(20, 3);
translate([60, 0, 0]) cube([total([1, 2, 3]), fib(7), 4]);
