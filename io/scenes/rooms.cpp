// Furnished flats for experiments: another one for every seed. The walls have thickness and are closed: light comes in
// through windows, which are open holes with frames, and from lamps.
#include <algorithm>

#include "core/host_math.h"
#include "io/scenes/generate.h"
#include "io/scenes/rooms_parts.h"

namespace plumb::io::scenes {
namespace {

using namespace flat;

constexpr double skirting = 0.09;

// A wall's lines: its ends, the edges of its openings, and what cuts it into cells of about `cell` metres.
std::vector<double> lines(double from, double to, std::vector<double> edges, double cell) {
    edges.push_back(from), edges.push_back(to);
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    std::vector<double> all;
    for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
        const int parts = std::max(1, int((edges[k + 1] - edges[k]) / cell + 0.5));
        for (int i = 0; i < parts; ++i) all.push_back(edges[k] + (edges[k + 1] - edges[k]) * i / parts);
    }
    all.push_back(edges.back());
    return all;
}

void wall_with_openings(Builder& b, int material, const Place& place, double from, double to, double low, double high,
                        const std::vector<Opening>& openings, double cell) {
    std::vector<double> across, up;
    for (const Opening& o : openings) across.insert(across.end(), {o.from, o.to}), up.insert(up.end(), {o.low, o.high});
    const std::vector<double> xs = lines(from, to, across, cell), ys = lines(low, high, up, cell);
    b.sheet(
        material, place, xs, ys,
        [&](int i, int j) {
            const double x = 0.5 * (xs[std::size_t(i)] + xs[std::size_t(i) + 1]),
                         y = 0.5 * (ys[std::size_t(j)] + ys[std::size_t(j) + 1]);
            for (const Opening& o : openings)
                if (x > o.from && x < o.to && y > o.low && y < o.high) return true;
            return false;
        },
        2);
}

// The four faces inside an opening, `deep` metres away from the room.
void reveal(Builder& b, int material, int floor, const Place& place, const Opening& o, double deep) {
    const Point near[4] = {{o.from, o.low, 0}, {o.to, o.low, 0}, {o.to, o.high, 0}, {o.from, o.high, 0}};
    for (int k = 0; k < 4; ++k) {
        const Point a = near[k], c = near[(k + 1) % 4], back(0, 0, -deep);
        const Point side[4] = {a, c, c + back, a + back};
        b.quad(k == 0 ? floor : material, place, side);
    }
}

void window_frame(Builder& b, const Finish& f, const Place& place, const Opening& o) {
    const double w = 0.06, z0 = -outer_wall * 0.6, z1 = z0 + 0.06, middle = (o.from + o.to) / 2,
                 y = o.low + 0.66 * (o.high - o.low);
    b.box(f.white, place, {o.from, o.low, z0}, {o.from + w, o.high, z1});
    b.box(f.white, place, {o.to - w, o.low, z0}, {o.to, o.high, z1});
    b.box(f.white, place, {o.from + w, o.low, z0}, {o.to - w, o.low + w, z1});
    b.box(f.white, place, {o.from + w, o.high - w, z0}, {o.to - w, o.high, z1});
    b.box(f.white, place, {middle - w / 2, o.low + w, z0}, {middle + w / 2, o.high - w, z1});
    b.box(f.white, place, {o.from + w, y - w / 2, z0 + 0.01}, {o.to - w, y + w / 2, z1 - 0.01});
    b.box(f.sill, place, {o.from - 0.06, o.low - 0.03, 0.001}, {o.to + 0.06, o.low + 0.01, 0.14});
}

void door_frame(Builder& b, const Finish& f, const Place& place, const Opening& o) {
    for (int k = 0; k < 2; ++k) {
        const double x0 = k ? o.to : o.from - 0.08, x1 = k ? o.to + 0.08 : o.from;
        b.box(f.white, place, {x0, 0.002, 0.001}, {x1, o.high, 0.02});
    }
    b.box(f.white, place, {o.from - 0.08, o.high, 0.001}, {o.to + 0.08, o.high + 0.08, 0.02});
}

// One room's surfaces: walls, floor, ceiling, what is in its openings.
void shell(Builder& b, const Finish& f, const Flat& flat, const Room& room, int wall, double cell) {
    for (int side = 0; side < 4; ++side) {
        const Place place = side_frame(room, side);
        const std::vector<Opening>& openings = room.openings[std::size_t(side)];
        wall_with_openings(b, wall, place, 0, side_length(room, side), 0, flat.height, openings, cell);
        std::vector<double> stops{0};
        for (const Opening& o : openings) {
            // Both rooms make half of a door's reveal.
            reveal(b, o.window ? f.white : f.wood[0], o.window ? f.white : f.floor, place, o,
                   o.window ? outer_wall : inner_wall / 2);
            o.window ? window_frame(b, f, place, o) : door_frame(b, f, place, o);
            if (!o.window) stops.insert(stops.end(), {o.from - 0.08, o.to + 0.08});
        }
        stops.push_back(side_length(room, side));
        std::sort(stops.begin(), stops.end());
        for (std::size_t k = 0; k + 1 < stops.size(); k += 2)
            if (stops[k + 1] > stops[k] + 0.02)
                b.box(f.white, place, {stops[k], 0.002, 0.001}, {stops[k + 1], skirting, 0.015});
    }
    const Box& r = room.floor;
    const int columns = std::max(1, int(room.width() / cell + 0.5)), rows = std::max(1, int(room.depth() / cell + 0.5));
    const Point down[4] = {{r.x0, 0, r.z1}, {r.x1, 0, r.z1}, {r.x1, 0, r.z0}, {r.x0, 0, r.z0}};
    const Point up[4] = {
        {r.x0, flat.height, r.z0}, {r.x1, flat.height, r.z0}, {r.x1, flat.height, r.z1}, {r.x0, flat.height, r.z1}};
    b.quad(f.floor, Place(1), down, columns, rows, 2.4);
    b.quad(f.ceiling, Place(1), up, columns, rows, 2);
}

// The outside: walls with the same windows, and a roof; so that the sun meets a solid house.
void outside(Builder& b, const Finish& f, const Flat& flat) {
    const Box o{flat.floor.x0 - outer_wall, flat.floor.z0 - outer_wall, flat.floor.x1 + outer_wall,
                flat.floor.z1 + outer_wall};
    const double low = -0.3, high = flat.height + 0.3;
    const Point corner[4] = {{o.x0, 0, o.z1}, {o.x1, 0, o.z1}, {o.x1, 0, o.z0}, {o.x0, 0, o.z0}};
    const int side_of[4] = {2, 1, 0, 3};
    for (int k = 0; k < 4; ++k) {
        // From outside one walks the other way round.
        const double length = k % 2 ? o.z1 - o.z0 : o.x1 - o.x0;
        std::vector<Opening> holes;
        for (const Room& room : flat.rooms) {
            if (!room.outside[std::size_t(side_of[k])]) continue;
            const double begin[4] = {room.floor.x1 - o.x0, o.z1 - room.floor.z0, o.x1 - room.floor.x0,
                                     room.floor.z1 - o.z0};
            for (const Opening& w : room.openings[std::size_t(side_of[k])])
                holes.push_back({begin[k] - w.to, begin[k] - w.from, w.low, w.high, true});
        }
        wall_with_openings(b, f.wall[0], move(corner[k]) * turn_y(90.0 * k), 0, length, low, high, holes, 100);
    }
    const Point roof[4] = {{o.x0, high, o.z1}, {o.x1, high, o.z1}, {o.x1, high, o.z0}, {o.x0, high, o.z0}};
    const Point base[4] = {{o.x0, low, o.z0}, {o.x1, low, o.z0}, {o.x1, low, o.z1}, {o.x0, low, o.z1}};
    b.quad(f.wall[0], Place(1), roof, 1, 1, 2);
    b.quad(f.wall[0], Place(1), base, 1, 1, 2);
}

void build(Builder& b, const Finish& f, const Flat& flat, std::uint32_t seed, double detail, double cell) {
    b.object("outside");
    outside(b, f, flat);
    for (std::size_t k = 0; k < flat.rooms.size(); ++k) {
        b.object("room " + std::to_string(k + 1));
        shell(b, f, flat, flat.rooms[k], f.wall[k % 4], cell);
        b.object("furniture " + std::to_string(k + 1));
        furnish(b, f, flat, flat.rooms[k], detail, seed * 131 + std::uint32_t(k));
    }
}

// Daylight through a window of the main room, or of any.
void add_sun(Scene& scene, const Flat& flat, Dice& dice) {
    const glm::dvec2 inwards[4] = {{0, 1}, {-1, 0}, {0, -1}, {1, 0}};
    const int first = dice.pick(4);
    for (int k = 0; k < 4; ++k) {
        const int side = (first + k) % 4;
        const auto& openings = flat.rooms[std::size_t(flat.main)].openings[std::size_t(side)];
        if (!flat.rooms[std::size_t(flat.main)].outside[std::size_t(side)] || openings.empty()) continue;
        const double aside = dice.between(-0.5, 0.5);
        const glm::dvec2 in = inwards[side], across(-in.y, in.x);
        Point d(in.x + aside * across.x, -dice.between(0.5, 0.9), in.y + aside * across.y);
        d /= std::sqrt(glm::dot(d, d));
        Light sun;
        sun.name = "sun", sun.type = LightType::directional, sun.rsm_size = 1024;
        sun.direction = glm::vec3(d), sun.intensity = {22, 20, 17};
        scene.lights.push_back(sun);
        return;
    }
}

}  // namespace

Scene rooms(const GenerateOptions& options) {
    const double wanted = double(options.triangles > 0 ? options.triangles : 60'000);
    Dice dice{options.seed, dice_row};
    const Flat flat = plan_flat(dice);
    Builder b("rooms");
    Dice taste{options.seed * 2654435761u + 17, dice_row};
    const Finish finish = make_finish(b, taste);

    // Furniture as fine as six tenths of the triangles allow; cells of walls, floors and ceilings take the rest.
    const double detail = fit_detail(std::int64_t(0.6 * wanted), 1, 200, [&](Builder& trial, double d) {
        build(trial, finish, flat, options.seed, d, 100);
    });
    const double density = fit_detail(std::int64_t(wanted), 0.01, 400, [&](Builder& trial, double per_metre) {
        build(trial, finish, flat, options.seed, detail, 1 / per_metre);
    });
    build(b, finish, flat, options.seed, detail, 1 / density);

    // Eye height, from a corner across the largest room.
    Scene scene = b.take();
    const Room& room = flat.rooms[std::size_t(flat.main)];
    const double mx = (room.floor.x0 + room.floor.x1) / 2, mz = (room.floor.z0 + room.floor.z1) / 2;
    scene.camera = {{flat.camera.x, 1.55, flat.camera.y}, {mx, 1.05, mz}, {0, 1, 0}, 60, 0.05, 60};
    Light lamp;
    lamp.name = "lamp", lamp.position = {float(mx), float(flat.height - 0.66), float(mz)};
    lamp.cone_inner_deg = 60, lamp.cone_outer_deg = 75, lamp.intensity = glm::vec3(26, 24, 20.5f);
    const bool sunny = dice.chance(0.6);
    if (sunny) lamp.intensity *= 0.4f;
    scene.lights.push_back(lamp);
    if (sunny) add_sun(scene, flat, dice);
    scene.environment.radiance = {1.4f, 1.8f, 2.4f};
    scene.frame_size = {1280, 720};
    // The disc spans the map: what the lamp does not reach gathers from all that it does.
    const std::string place = "rooms";
    scene.settings = {{"rsm", "radius", 1.0, place}, {"rsm", "samples", 1024.0, place},
                      {"rsm", "projection", std::string("clamped"), place}, {"rsm", "min_distance", 0.3, place},
                      {"tonemap", "operator", std::string("filmic"), place}, {"tonemap", "exposure", 1.6, place}};
    scene.seed = options.seed;
    return scene;
}

}  // namespace plumb::io::scenes
