#include "engine/edges/shortest_path.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/sampling.h"

using aula::DiffractionEdge;
using aula::ShortestPath;

namespace {

/// Random edges of 0.3 to 3 m between two points.
struct Course {
    explicit Course(std::uint64_t seed, std::size_t count) {
        aula::RandomStream random(seed);
        const auto between = [&](double low, double high) {
            return low + (high - low) * double{random.uniform()};
        };
        const auto point = [&](double x) {
            return glm::dvec3(x + between(-0.5, 0.5), between(-2, 2), between(-2, 2));
        };
        from = point(0);
        for (std::size_t i = 0; i < count; ++i) {
            DiffractionEdge edge;
            edge.start = point(static_cast<double>(i + 1));
            edge.axis = glm::normalize(point(0));
            edge.length_m = between(0.3, 3);
            edges.push_back(edge);
        }
        to = point(static_cast<double>(count + 1));
        for (const DiffractionEdge& edge : edges) pointers.push_back(&edge);
    }

    double length_m(const std::vector<double>& along_m) const {
        double sum = 0;
        glm::dvec3 last = from;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            sum += glm::distance(last, edges[i].point(along_m[i]));
            last = edges[i].point(along_m[i]);
        }
        return sum + glm::distance(last, to);
    }

    glm::dvec3 from{0};
    glm::dvec3 to{0};
    std::vector<DiffractionEdge> edges;
    std::vector<const DiffractionEdge*> pointers;
};

}  // namespace

TEST_CASE("the shortest path over random edges cannot be shortened") {
    int at_ends = 0;
    int longer_by_halves = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const Course course(seed, 1 + seed % 6);
        const ShortestPath path = shortest_path(course.from, course.pointers, course.to);
        REQUIRE(path.along_m.size() == course.edges.size());
        const double length_m = course.length_m(path.along_m);
        CAPTURE(seed);
        CHECK(path.length_m == Approx(length_m).margin(1e-9));
        std::vector<double> middles;
        for (std::size_t i = 0; i < course.edges.size(); ++i) {
            const double end_m = course.edges[i].length_m;
            CHECK(path.along_m[i] >= 0);
            CHECK(path.along_m[i] <= end_m);
            if (path.along_m[i] == 0 || path.along_m[i] == end_m) ++at_ends;
            middles.push_back(end_m / 2);
            // The length is convex: a local minimum of each coordinate and of their sums is the
            // minimum. Both directions of a millimetre along each edge are longer.
            for (const double shift_m : {-1e-3, 1e-3}) {
                std::vector<double> moved = path.along_m;
                moved[i] = std::clamp(moved[i] + shift_m, 0.0, end_m);
                CHECK(course.length_m(moved) >= length_m - 1e-12);
            }
        }
        aula::RandomStream random(seed);
        for (int trial = 0; trial < 20; ++trial) {
            std::vector<double> moved = path.along_m;
            for (std::size_t i = 0; i < moved.size(); ++i) {
                const double shift_m = 0.02 * (double{random.uniform()} - 0.5);
                moved[i] = std::clamp(moved[i] + shift_m, 0.0, course.edges[i].length_m);
            }
            CHECK(course.length_m(moved) >= length_m - 1e-12);
        }
        if (course.length_m(middles) > length_m + 1e-3) ++longer_by_halves;
    }
    CHECK(at_ends > 50);
    CHECK(longer_by_halves > 190);
}

TEST_CASE("a path over parallel edges is a straight line when their planes are unfolded") {
    // Edges along z at x = 0, 0.5, 1.3 and y = 1: the path advances evenly along z.
    std::vector<DiffractionEdge> edges(3);
    const std::vector<double> x_m{0, 0.5, 1.3};
    for (std::size_t i = 0; i < 3; ++i) {
        edges[i].start = {x_m[i], 1, -5};
        edges[i].axis = {0, 0, 1};
        edges[i].length_m = 10;
    }
    const std::vector<const DiffractionEdge*> pointers{edges.data(), &edges[1], &edges[2]};
    const glm::dvec3 from(-2, 0, -1);
    const glm::dvec3 to(2.3, -1, 2);
    const ShortestPath path = shortest_path(from, pointers, to);
    const std::vector<double> across_m{std::hypot(2, 1), 0.5, 0.8, std::hypot(1, 2)};
    double walked_m = 0;
    double total_m = 0;
    for (const double d : across_m) total_m += d;
    for (std::size_t i = 0; i < 3; ++i) {
        walked_m += across_m[i];
        CHECK(path.along_m[i] == Approx(4 + 3 * walked_m / total_m).epsilon(1e-9));
    }
    CHECK(path.length_m == Approx(std::hypot(total_m, 3)).epsilon(1e-12));
}

TEST_CASE("a path over edges that meet in a corner passes through it") {
    // Both edges start at the corner and turn away from the straight line.
    std::vector<DiffractionEdge> edges(2);
    edges[0].axis = glm::normalize(glm::dvec3(-1, 3, 0));
    edges[1].axis = glm::normalize(glm::dvec3(1, 3, 0));
    for (DiffractionEdge& edge : edges) edge.length_m = 2;
    const std::vector<const DiffractionEdge*> pointers{edges.data(), &edges[1]};
    const ShortestPath path = shortest_path({-3, -1, 0}, pointers, {3, -1, 0});
    CHECK(path.along_m == std::vector<double>{0, 0});
    CHECK(path.length_m == Approx(2 * std::sqrt(10)));
}
