// A plate with raised and with cut letters; the font is one that both programs have.
$fn = 32;
difference() {
    translate([-32, -8, 0]) cube([64, 26, 3]);
    translate([0, 8, 2]) linear_extrude(2)
        text("Lathe", size = 8, font = "DejaVu Sans", halign = "center", valign = "center");
}
translate([0, -4, 3]) linear_extrude(1.5) text("No. 5", size = 5, font = "DejaVu Sans", halign = "center");
