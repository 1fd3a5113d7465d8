// The boxes of HEM 5.8 as radiosity takes them.
#include <catch2/catch.hpp>

#include "gi/radiosity/contacts.h"
#include "gi/radiosity/elements.h"
#include "io/scenes/generate.h"

using namespace plumb;
using namespace plumb::radiosity;

TEST_CASE("hemicube_box: an element a vertex of the file, as HEM 5.8 counts them", "[radiosity][HEM 5.8]") {
    const std::pair<std::int64_t, int> published[] = {{1200, 774}, {4800, 2734}, {30000, 15814}};
    ElementParams p;
    p.of_file = true, p.inset = false;
    for (const auto& [triangles, vertices] : published) {
        const Elements e = elements_of(io::generate_scene("hemicube_box", {triangles, 1}, "test"), p);
        CHECK(e.count() == vertices);
        CHECK(e.nearer == 0);
        double area = 0, emitted = 0;
        for (std::size_t i = 0; i < e.area.size(); ++i) area += e.area[i], emitted += e.area[i] * e.exitance[i].x;
        CHECK(area == Approx(24).epsilon(1e-6));
        CHECK(emitted == Approx(100.4 * 0.16).epsilon(1e-6));
    }
}

TEST_CASE("hemicube_shapes: elements, no T-junction and no contact", "[radiosity][HEM C.10]") {
    const Scene s = io::generate_scene("hemicube_shapes", {}, "test");
    const Elements e = elements_of(s, {});
    // Five walls of 11^2, the ceiling's 11^2 - 1 and its lamp's 3^2; the sphere's 642; the torus' 50 x 25, its seams closed.
    CHECK(e.count() == 605 + 120 + 9 + 642 + 1250);
    CHECK(e.without_normal == 0);
    CHECK(e.inset == 5 * 40 + 40 + 8 + 8);  // borders of walls, of the ceiling, of the lamp on both its sides
    const Contacts c = inspect_contacts(e.geometry);
    CHECK(c.t_junctions == 0);
    CHECK(c.nearly_equal == 0);
    CHECK(c.contacts == 0);
}
