#include "aula/engine/directivity.h"

#include <sys/stat.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "aula/exception.h"
#include "engine/base/sampling.h"
#include "tests/support/temporary_folder.h"

namespace directivity_test {

using namespace aula;

namespace {

constexpr double kPi = std::numbers::pi;

Vec3 direction(double azimuth_rad, double elevation_rad) {
    return Vec3(std::cos(azimuth_rad) * std::cos(elevation_rad),
                std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad));
}

/// The largest error of the mean over all directions, of all bands. Midpoints in cells of equal
/// area.
double power_error(const std::function<Bands(const Vec3&)>& energy) {
    constexpr int kRows = 400;
    constexpr int kColumns = 400;
    std::array<double, kBandCount> mean{};
    for (int r = 0; r < kRows; ++r) {
        for (int c = 0; c < kColumns; ++c) {
            const Bands e = energy(
                direction(2 * kPi * (c + 0.5) / kColumns, std::asin(-1 + 2 * (r + 0.5) / kRows)));
            for (std::size_t b = 0; b < kBandCount; ++b)
                mean[b] += double{e[b]} / (kRows * kColumns);
        }
    }
    double largest = 0;
    for (const double m : mean) largest = std::max(largest, std::abs(m - 1));
    return largest;
}

/// The largest difference of two patterns in the first band.
double difference(const std::function<double(const Vec3&)>& a,
                  const std::function<double(const Vec3&)>& b) {
    double largest = 0;
    const ScrambledSobol points(1);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const Vec3 d = uniform_direction(points.point(i));
        largest = std::max(largest, std::abs(a(d) - b(d)));
    }
    return largest;
}

/// Energies of a table with steps of 180 / (rows - 1) degrees.
std::vector<Bands> sampled(std::size_t rows, const std::function<Bands(const Vec3&)>& energy) {
    const std::size_t columns = 2 * (rows - 1);
    std::vector<Bands> table;
    for (std::size_t r = 0; r < rows; ++r) {
        for (std::size_t c = 0; c < columns; ++c) {
            const double step_rad = kPi / static_cast<double>(rows - 1);
            table.push_back(energy(direction(static_cast<double>(c) * step_rad,
                                             static_cast<double>(r) * step_rad - kPi / 2)));
        }
    }
    return table;
}

std::vector<Bands> random_table(std::size_t rows) {
    RandomStream random(7);
    return sampled(rows, [&](const Vec3&) {
        Bands energy;
        for (float& e : energy.value) e = random.uniform();
        return energy;
    });
}

}  // namespace

TEST_CASE("every directivity has the power of an omnidirectional source in each band") {
    // Midpoint rule: (pi / 400)^2 / 24 times second derivatives below 100, the narrowest beam at 8
    // kHz. A table of random values has jumps of the second derivative: 1e-3.
    constexpr double kQuadrature = 1e-3;
    for (const std::string& name : Directivity::names()) {
        const Directivity shipped = *Directivity::find(name);
        CAPTURE(name);
        CHECK(power_error([&](const Vec3& d) { return shipped.factor(d); }) < kQuadrature);
    }
    const Directivity table = Directivity::table(13, 24, random_table(13));
    CHECK(power_error([&](const Vec3& d) { return table.factor(d); }) < kQuadrature);
    // Companion: a cardioid of the level 0 dB to the front has a third of the power.
    const Directivity cardioid = *Directivity::find("cardioid");
    CHECK(power_error([&](const Vec3& d) { return cardioid.factor(d) * (1.0F / 3); }) > 0.6);
}

TEST_CASE("the cardioid family has the factor of its formula") {
    const auto factor = [](const char* name, const Vec3& d) {
        return double{Directivity::find(name)->factor(d)[3]};
    };
    const Vec3 front(1, 0, 0);
    const Vec3 left(0, 1, 0);
    const auto is = [](double value) { return Approx(value).margin(1e-6); };  // rounding
    CHECK(factor("cardioid", front) == is(3));
    CHECK(factor("cardioid", left) == is(0.75));
    CHECK(factor("cardioid", -front) == is(0));
    CHECK(factor("figure_of_eight", front) == is(3));
    CHECK(factor("figure_of_eight", left) == is(0));
    CHECK(factor("figure_of_eight", -front) == is(3));
    CHECK(factor("subcardioid", front) == is(1 / 0.52));
    CHECK(factor("subcardioid", -front) == is(0.16 / 0.52));
    const double a = (std::sqrt(3.0) - 1) / 2;
    CHECK(factor("supercardioid", front) == is(1 / (a * a + (1 - a) * (1 - a) / 3)));
    // A supercardioid sends 14 times more to the front half than to the rear half, 7 + 4 sqrt(3).
    double half[2] = {0, 0};
    for (int i = 0; i < 2000; ++i) {
        const double cosine = -1 + (i + 0.5) / 1000;
        half[cosine > 0] += factor("supercardioid", direction(std::acos(cosine), 0));
    }
    CHECK(half[1] / half[0] == Approx(7 + 4 * std::sqrt(3.0)).epsilon(1e-4));  // midpoint rule
    CHECK(Directivity::find("omni")->is_omnidirectional());
    CHECK_FALSE(Directivity::find("cardoid"));
}

TEST_CASE("talker and loudspeaker have the levels of a vibrating cap in a rigid sphere") {
    // Computed by SciPy from the same series, at 0, 30, 60, 90, 120, 150 and 180 degrees in dB.
    struct Truth {
        const char* name;
        std::size_t band;
        std::array<double, 7> level_db;
    };
    const Truth truths[] = {
        {"talker", 4, {2.722, 2.396, 1.409, -0.364, -3.217, -2.268, -0.42}},
        {"talker", 6, {4.296, 3.711, 1.988, -0.968, -5.037, -8.432, -2.237}},
        {"talker", 7, {7.471, 5.632, 1.335, -3.667, -9.223, -14.604, -6.414}},
        {"loudspeaker", 2, {1.548, 1.236, 0.385, -0.546, -0.708, -0.158, 0.162}},
        {"loudspeaker", 5, {3.946, 3.449, 1.949, -0.743, -4.624, -8.172, -1.766}},
        {"loudspeaker", 7, {12.004, 6.874, -3.385, -9.22, -15.542, -22.277, -13.259}}};
    const auto largest_error_db = [&](const Vec3& front) {
        double largest = 0;
        for (const Truth& truth : truths) {
            const Directivity cap = *Directivity::find(truth.name);
            for (std::size_t i = 0; i < truth.level_db.size(); ++i) {
                const double angle_rad = static_cast<double>(i) * kPi / 6;
                const Vec3 d =
                    direction(angle_rad + std::atan2(double{front.y}, double{front.x}), 0);
                const double level_db = 10 * std::log10(double{cap.factor(d)[truth.band]});
                largest = std::max(largest, std::abs(level_db - truth.level_db[i]));
            }
        }
        return largest;
    };
    CHECK(largest_error_db({1, 0, 0}) < 0.01);  // the table has three decimals, single precision
    CHECK(largest_error_db({0, 1, 0}) > 1);     // companion: turned
    // A sphere that vibrates as a whole is omnidirectional.
    const Directivity sphere = Directivity::vibrating_cap(0.2F, std::numbers::pi_v<float> - 1e-3F);
    const auto one = [](const Vec3&) { return 1.0; };
    CHECK(difference([&](const Vec3& d) { return double{sphere.factor(d)[7]}; }, one) < 1e-3);
    const Directivity most = Directivity::vibrating_cap(0.2F, 2.6F);
    CHECK(difference([&](const Vec3& d) { return double{most.factor(d)[7]}; }, one) > 1e-2);
}

TEST_CASE("a table has the closed form within the error of its interpolation") {
    const Directivity cardioid = *Directivity::find("cardioid");
    const auto exact = [&](const Vec3& d) { return double{cardioid.factor(d)[0]}; };
    const auto error_of = [&](std::size_t rows) {
        // On any scale.
        const Directivity table = Directivity::table(
            rows, 2 * (rows - 1),
            sampled(rows, [&](const Vec3& d) { return cardioid.factor(d) * 7; }));
        return difference([&](const Vec3& d) { return double{table.factor(d)[0]}; }, exact);
    };
    // The slopes err by h^2 f''' / 6, the polynomial by 0.096 h times that, in two coordinates.
    // Third derivatives of 0.75 (1 + cos)^2 are below 4.5; h is the step. The mean has less.
    const auto bound = [](double h) {
        return 2 * 0.096 * h * h * h * 4.5 / 6 + h * h * h * h * 0.03;
    };
    CHECK(error_of(19) < bound(kPi / 18));
    CHECK(error_of(37) < bound(kPi / 36));
    CHECK(error_of(7) > bound(kPi / 18));  // companion: steps of 30 degrees
}

TEST_CASE("a table is continuous across the azimuth's seam, at the poles and between cells") {
    constexpr std::size_t kRows = 13;
    constexpr std::size_t kColumns = 24;
    const std::vector<Bands> energy = random_table(kRows);
    const Directivity table = Directivity::table(kRows, kColumns, energy);
    constexpr double kStep_rad = 1e-4;
    const auto largest_step = [&](const std::function<double(const Vec3&)>& value) {
        double largest = 0;
        const auto compare = [&](const Vec3& a, const Vec3& b) {
            largest = std::max(largest, std::abs(value(a) - value(b)));
        };
        for (int i = -85; i <= 85; ++i) {
            const double elevation_rad = i * kPi / 180;
            for (const double seam_rad : {0.0, kPi, kPi / 12, 1.0}) {
                compare(direction(seam_rad - kStep_rad / 2, elevation_rad),
                        direction(seam_rad + kStep_rad / 2, elevation_rad));
            }
        }
        for (int i = 0; i < 36; ++i) {
            for (const double pole_rad : {-kPi / 2, kPi / 2}) {
                const double near_rad = pole_rad * (1 - kStep_rad / kPi);
                compare(direction(i * kPi / 36, near_rad), direction(i * kPi / 36 + kPi, near_rad));
                compare(direction(i * kPi / 36, near_rad), direction(i * kPi / 36 + 1, near_rad));
            }
        }
        return largest;
    };
    // Values of 0 to 2.1, 15 degrees apart: slopes of cubic polynomials below 2 x 2.1 / (pi / 12)
    // in each coordinate.
    const double bound = kStep_rad * 2 * 2 * 2.1 / (kPi / 12);
    CHECK(largest_step([&](const Vec3& d) { return double{table.factor(d)[2]}; }) < bound);
    // Companion: the nearest entry of the table.
    CHECK(largest_step([&](const Vec3& d) {
              const double row = (std::asin(double{d.z}) / kPi + 0.5) * (kRows - 1);
              double turn = std::atan2(double{d.y}, double{d.x}) / (2 * kPi);
              if (turn < 0) turn += 1;
              const auto column = static_cast<std::size_t>(turn * kColumns) % kColumns;
              return double{energy[static_cast<std::size_t>(row + 0.5) * kColumns + column][2]};
          }) > 10 * bound);
}

TEST_CASE("a table without energy or of a wrong size is refused") {
    const std::vector<Bands> silent(3 * 4);
    CHECK_THROWS_AS(Directivity::table(3, 4, silent), InputError);
    CHECK_THROWS_AS(Directivity::table(3, 4, std::vector<Bands>(11, Bands::filled(1))), InputError);
    CHECK_THROWS_AS(Directivity::table(3, 5, std::vector<Bands>(15, Bands::filled(1))), InputError);
    CHECK_THROWS_AS(Directivity::table(2, 4, std::vector<Bands>(8, Bands::filled(1))), InputError);
    CHECK_THROWS_AS(Directivity::table(3, 4, std::vector<Bands>(12, Bands::filled(NAN))),
                    InputError);
    CHECK_NOTHROW(Directivity::table(3, 4, std::vector<Bands>(12, Bands::filled(1))));
}

TEST_CASE("a directivity is read from JSON, and each error in it has a place") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "horn.json";
    const std::string rows = "[[0,0,0,0],[10,0,-10,0],[0,0,0,0]]";
    const auto bands = [](const std::string& band, const std::string& last) {
        std::string text = "[";
        for (int b = 0; b < 7; ++b) text += band + ",";
        return text + last + "]";
    };
    const auto load = [&](const std::string& text) {
        std::ofstream(file) << text;
        return load_directivity(file);
    };
    const auto message = [&](const std::string& text) -> std::string {
        try {
            load(text);
        } catch (const InputError& error) {
            return error.what();
        }
        return "none";
    };
    const std::string begin = R"({"aula_directivity": 1, "level_db": )";
    const Directivity horn = load(begin + bands(rows, rows) + "}");
    const double front = double{horn.factor({1, 0, 0})[0]};
    CHECK(front / double{horn.factor({0, 1, 0})[0]} == Approx(10));
    CHECK(front / double{horn.factor({-1, 0, 0})[7]} == Approx(100));
    // Columns by azimuth: front, left, back, right.
    const std::string four = "[[0,0,0,0],[0,3,6,9],[0,0,0,0]]";
    const Directivity turned = load(begin + bands(four, four) + "}");
    const std::array<Vec3, 4> columns{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0)};
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const float ratio = turned.factor(columns[c])[3] / turned.factor(columns[0])[3];
        CHECK(10 * std::log10(double{ratio}) == Approx(3 * static_cast<double>(c)).margin(1e-4));
    }
    const auto has = [&](const std::string& text, const std::string& part) {
        INFO(message(text));
        CHECK(message(text).find(file.string()) == 0);
        CHECK(message(text).find(part) != std::string::npos);
        CHECK(message(text).find('\n') == std::string::npos);
    };
    has("{", "line 1, column 2");
    has(R"({"aula_directivity": 1})", "level_db: missing");
    has(R"({"level_db": []})", "aula_directivity: missing");
    has(begin + "[1,2]}", "/level_db: a list of 2; expected a list of 8 tables");
    has(begin + bands(rows, "[[0,0,0,0]]") + "}", "/level_db/7: a list of 1;");
    has(begin + bands(rows, "[[0,0,0,0],[0,0],[0,0,0,0]]") + "}", "/level_db/7/1: a list of 2;");
    has(begin + bands(rows, "[[0,0,0,0],[0,NaN,0,0],[0,0,0,0]]") + "}", "/level_db/7/1/1: NaN");
    has(begin + bands(rows, "[[0,0,0,0],[0,0,1e9,0],[0,0,0,0]]") + "}",
        "/level_db/7/1/2: 1e+09 is out of range");
    has(begin + bands("[]", "[]") + "}", "/level_db/0: a list of 0;");
    has(begin + bands("[[],[],[]]", "[[],[],[]]") + "}", "/level_db/0: a list of 3;");
    has(begin + bands("[[0,0,0],[0,0,0],[0,0,0]]", "[[0,0,0],[0,0,0],[0,0,0]]") + "}",
        "/level_db: a directivity of 3 elevations and 3 azimuths;");
    CHECK(message(begin + bands(rows, rows) + ", \"levels\": 1}").find("unknown key") !=
          std::string::npos);
}

TEST_CASE("a directivity in JSON has at most 361 elevations and 720 azimuths") {
    const test::TemporaryFolder folder;
    const auto bands = [](std::size_t elevations, std::size_t azimuths) {
        std::string row = "[0";
        for (std::size_t c = 1; c < azimuths; ++c) row += ",0";
        row += "]";
        std::string table = "[" + row;
        for (std::size_t r = 1; r < elevations; ++r) table += "," + row;
        table += "]";
        std::string text = table;
        for (std::size_t b = 1; b < kBandCount; ++b) text += "," + table;
        return R"({"aula_directivity": 1, "level_db": [)" + text + "]}";
    };
    const auto load = [&](const std::string& text) {
        return load_directivity(folder.write("fine.json", text));
    };
    CHECK_NOTHROW(load(bands(361, 4)));
    CHECK_NOTHROW(load(bands(3, 720)));
    for (const auto& [elevations, azimuths] : {std::pair(362U, 4U), std::pair(3U, 722U)}) {
        CHECK_THROWS_WITH(load(bands(elevations, azimuths)),
                          Catch::EndsWith("/level_db/0: a table of " + std::to_string(elevations) +
                                          " elevations and " + std::to_string(azimuths) +
                                          " azimuths; expected at most 361 and 720"));
    }
}

TEST_CASE("a file that cannot hold a directivity has the same message in both formats") {
    const test::TemporaryFolder folder;
    for (const char* name : {"missing", "folder", "pipe"}) {
        for (const char* format : {".json", ".sofa"}) {
            const auto file = folder.path() / (std::string(name) + format);
            const bool missing = name == std::string("missing");
            if (name == std::string("folder")) std::filesystem::create_directory(file);
            if (name == std::string("pipe")) REQUIRE(mkfifo(file.c_str(), 0600) == 0);
            const char* const problem = missing ? ": no such file; expected a SOFA "
                                        : name == std::string("folder")
                                            ? ": is a folder, not a regular file; expected a SOFA "
                                            : ": is not a regular file; expected a SOFA ";
            CHECK_THROWS_WITH(load_directivity(file), Catch::StartsWith(file.string() + problem));
        }
    }
}

TEST_CASE("a directivity of more than 64 MiB is refused by its name") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "large.json";
    std::ofstream(file).close();
    std::filesystem::resize_file(file, (std::uintmax_t{64} << 20U) + 1);
    CHECK_THROWS_WITH(load_directivity(file),
                      file.string() + ": holds 67108865 bytes; expected at most 67108864");
}

}  // namespace directivity_test
