#include "engine/scene/directivity_measurements.h"

#include <hdf5.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>

#include "aula/exception.h"
#include "engine/base/sampling.h"
#include "tests/support/temporary_folder.h"

using namespace aula;

namespace {

constexpr double kPi = std::numbers::pi;

/// A numeric variable of a SOFA file.
struct Variable {
    std::string name;
    std::vector<hsize_t> sizes;
    std::vector<double> values;  ///< empty: not written, which needs no memory
    std::string type{};          ///< the attribute Type; empty: none
};

/// The content of a SOFA file.
struct Content {
    std::string conventions = "FreeFieldDirectivityTF";
    std::vector<Variable> variables;

    Variable& operator[](const std::string& name) {
        for (Variable& v : variables)
            if (v.name == name) return v;
        variables.push_back({name, {}, {}});
        return variables.back();
    }
};

void add_text(hid_t object, const char* name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size() + 1);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text.c_str());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
}

void write(const Content& content, const std::filesystem::path& file) {
    const hid_t out = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(out >= 0);
    add_text(out, "SOFAConventions", content.conventions);
    for (const Variable& v : content.variables) {
        const hid_t space =
            H5Screate_simple(static_cast<int>(v.sizes.size()), v.sizes.data(), nullptr);
        const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
        if (v.values.empty()) {
            const std::vector<hsize_t> chunk(v.sizes.size(), 1);
            H5Pset_chunk(layout, static_cast<int>(chunk.size()), chunk.data());
        }
        const hid_t set = H5Dcreate2(out, v.name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                     layout, H5P_DEFAULT);
        REQUIRE(set >= 0);
        if (!v.values.empty())
            H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, v.values.data());
        if (!v.type.empty()) add_text(set, "Type", v.type);
        H5Dclose(set);
        H5Pclose(layout);
        H5Sclose(space);
    }
    H5Fclose(out);
}

/// A cardioid, measured every `step_deg` degrees at 63, 1000 and 1100 Hz at varying distances. At
/// 63 Hz it is omnidirectional.
Content cardioid(int step_deg = 5) {
    std::vector<double> position;
    std::vector<double> real;
    std::vector<double> imaginary;
    for (int elevation = -90; elevation <= 90; elevation += step_deg) {
        for (int azimuth = 0; azimuth < 360; azimuth += step_deg) {
            const double distance_m = 1 + 0.001 * azimuth;
            position.insert(position.end(), {double(azimuth), double(elevation), distance_m});
            const double cosine = std::cos(azimuth * kPi / 180) * std::cos(elevation * kPi / 180);
            for (const double pressure : {1.0, 0.5 + 0.5 * cosine, 0.5 + 0.5 * cosine}) {
                const double phase = 0.1 * azimuth;
                real.push_back(pressure / distance_m * std::cos(phase));
                imaginary.push_back(pressure / distance_m * std::sin(phase));
            }
        }
    }
    const hsize_t directions = position.size() / 3;
    Content content;
    content.variables = {{"Data.Real", {1, directions, 3}, real},
                         {"Data.Imag", {1, directions, 3}, imaginary},
                         {"N", {3}, {63, 1000, 1100}},
                         {"ReceiverPosition", {directions, 3, 1}, position, "spherical"}};
    return content;
}

class SofaFolder {
 public:
    Directivity load(const Content& content) const {
        write(content, file());
        return load_directivity(file());
    }

    /// The message of the error, which is one line that begins with the file's name.
    std::string error() const {
        try {
            load_directivity(file());
        } catch (const InputError& error) {
            const std::string text = error.what();
            CHECK(text.find(file().string() + ": ") == 0);
            CHECK(text.find('\n') == std::string::npos);
            return text;
        }
        return "none";
    }
    std::string error(const Content& content) const {
        write(content, file());
        return error();
    }

    std::filesystem::path file() const { return folder_.path() / "source.sofa"; }

 private:
    test::TemporaryFolder folder_;
};

/// The largest difference from a cardioid that faces `front` at 1 kHz.
double cardioid_error(const Directivity& directivity, const Vec3& front) {
    double largest = 0;
    const ScrambledSobol points(1);
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const Vec3 d = uniform_direction(points.point(i));
        const double pressure = 0.5 + 0.5 * double{glm::dot(d, front)};
        largest =
            std::max(largest, std::abs(double{directivity.factor(d)[4]} - 3 * pressure * pressure));
    }
    return largest;
}

}  // namespace

TEST_CASE("a directivity in SOFA has its measured levels") {
    const SofaFolder folder;
    const Directivity directivity = folder.load(cardioid());
    // The error of the interpolation, as for a table (directivity_test.cpp).
    CHECK(cardioid_error(directivity, {1, 0, 0}) < 1e-3);
    CHECK(cardioid_error(directivity, {0, 1, 0}) > 1);  // companion
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0.6F, 0.8F)}) {
        const Bands factor = directivity.factor(d);
        CHECK(factor[0] == Approx(1).epsilon(1e-5));
        CHECK(factor[1] == Approx(1).epsilon(1e-5));  // the nearest band with a frequency
        CHECK(factor[7] == factor[4]);
    }
    SECTION("in the axes of its source") {
        Content turned = cardioid();
        turned["SourceView"] = {"SourceView", {1, 3}, {0, -1, 0}, "cartesian"};
        turned["SourceUp"] = {"SourceUp", {1, 3}, {0, 0, 1}, "cartesian"};
        // The source faces -y; its left is +x, where the cardioid points.
        CHECK(cardioid_error(folder.load(turned), {0, 1, 0}) < 1e-3);
    }
    SECTION("in Cartesian coordinates") {
        Content content = cardioid();
        Variable& position = content["ReceiverPosition"];
        for (std::size_t i = 0; i < position.values.size(); i += 3) {
            const double azimuth = position.values[i] * kPi / 180;
            const double elevation = position.values[i + 1] * kPi / 180;
            const double r = position.values[i + 2];
            position.values[i] = r * std::cos(azimuth) * std::cos(elevation);
            position.values[i + 1] = r * std::sin(azimuth) * std::cos(elevation);
            position.values[i + 2] = r * std::sin(elevation);
        }
        position.type = "cartesian";
        CHECK(cardioid_error(folder.load(content), {1, 0, 0}) < 1e-3);
        position.type = "spherical";
        CHECK(folder.error(content) != "none");  // companion: positions without a distance
    }
    SECTION("as the mean of all measurements") {
        Content content = cardioid();
        for (const char* name : {"Data.Real", "Data.Imag"}) {
            Variable& v = content[name];
            v.sizes[0] = 2;
            const std::size_t count = v.values.size();
            for (std::size_t i = 0; i < count; ++i) v.values.push_back(2 * v.values[i]);
        }
        CHECK(cardioid_error(folder.load(content), {1, 0, 0}) < 1e-3);
    }
}

TEST_CASE("few measured directions are interpolated") {
    const SofaFolder folder;
    const double error = cardioid_error(folder.load(cardioid(30)), {1, 0, 0});
    // The nearest direction alone errs by slopes up to 1.95 over up to 21 degrees. Neighbours on
    // all sides cancel more than half of that.
    const double nearest_error = 1.95 * std::sqrt(2) * kPi / 12;
    CHECK(error < 0.5 * nearest_error);
    CHECK(cardioid_error(folder.load(cardioid(90)), {1, 0, 0}) > 0.5 * nearest_error);  // companion
}

TEST_CASE("a SOFA file that is no directivity is refused in one line") {
    const SofaFolder folder;
    const auto is = [&](const Content& content, const std::string& part) {
        const std::string text = folder.error(content);
        INFO(text);
        CHECK(text.find(part) != std::string::npos);
    };
    const std::string sizes = "in sizes that fit; expected";
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    Content content = cardioid();
    CHECK(folder.error(content) == "none");
    content.conventions = "SimpleFreeFieldHRIR";
    is(content, "of another kind; expected a SOFA file of a source's directivity");

    const std::size_t last = content["Data.Real"].values.size() - 1;
    const std::vector<std::pair<std::string, std::function<void(Content&)>>> faults{
        {"a value is not finite", [&](Content& c) { c["Data.Real"].values[last] = nan; }},
        {"a value is not finite", [&](Content& c) { c["Data.Imag"].values[0] = infinity; }},
        {"a value is not finite", [&](Content& c) { c["N"].values[1] = nan; }},
        {"a direction is not one", [&](Content& c) { c["ReceiverPosition"].values[7] = nan; }},
        {"a direction is not one", [&](Content& c) { c["ReceiverPosition"].values[8] = 0; }},
        {"a direction is not one", [&](Content& c) { c["ReceiverPosition"].values[8] = 1e300; }},
        {"no frequency",
         [](Content& c) {
             c["N"].values = {1, 2, 3};
         }},
        {"no energy",
         [](Content& c) {
             for (const char* name : {"Data.Real", "Data.Imag"})
                 for (double& x : c[name].values) x = 0;
         }},
        {"negative or not finite",
         [](Content& c) {
             for (double& x : c["Data.Real"].values) x *= 1e30;
         }},
        {"of another kind", [](Content& c) { c["ReceiverPosition"].type = "spherical harmonics"; }},
        {"of another kind", [](Content& c) { c["ReceiverPosition"].type = ""; }},
        {"the axes of its source",
         [](Content& c) {
             c["SourceView"] = {"SourceView", {1, 3}, {0, 0, 2}, "cartesian"};
         }},
        {sizes,
         [](Content& c) {
             c["SourceView"] = {"SourceView", {1, 2}, {0, 1}};
         }},
        {sizes,
         [](Content& c) {
             c["N"] = {"N", {2}, {63, 125}};
         }},
        {sizes, [](Content& c) { c.variables.erase(c.variables.begin() + 2); }},
        {sizes, [](Content& c) { c.variables.erase(c.variables.begin()); }},
        {sizes,
         [](Content& c) {
             c["Data.Real"] = {"Data.Real", {4}, {1, 2, 3, 4}};
         }},
        {sizes,
         [](Content& c) {
             c["ReceiverPosition"] = {"ReceiverPosition", {1, 3, 1}, {0, 0, 1}, "spherical"};
         }},
        // A declared size without values needs no memory in the file.
        {"more than 16384",
         [](Content& c) {
             c["Data.Real"] = {"Data.Real", {1, 1 << 20, 1 << 20}, {}};
             c["Data.Imag"] = {"Data.Imag", {1, 1 << 20, 1 << 20}, {}};
         }},
        {"more than 16384",
         [](Content& c) {
             c["Data.Real"] = {"Data.Real", {hsize_t{1} << 60, 16, 16}, {}};
             c["Data.Imag"] = {"Data.Imag", {hsize_t{1} << 60, 16, 16}, {}};
         }},
        {sizes,
         [](Content& c) {
             c["N"] = {"N", {hsize_t{1} << 60}, {}};
         }},
    };
    for (const auto& [part, spoil] : faults) {
        Content spoiled = cardioid(30);
        const std::size_t count = spoiled["Data.Real"].values.size();
        if (last >= count) spoiled = cardioid();
        spoil(spoiled);
        is(spoiled, part);
    }
}

TEST_CASE("damaged SOFA files of directivities are refused in one line, or read") {
    const SofaFolder folder;
    write(cardioid(30), folder.file());
    std::ifstream in(folder.file(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const auto put = [&](const std::string& bytes) {
        std::ofstream(folder.file(), std::ios::binary | std::ios::trunc) << bytes;
    };
    for (const std::string& text : {std::string(), std::string("no SOFA file"),
                                    whole.substr(0, 100), whole.substr(0, whole.size() / 2)}) {
        put(text);
        CHECK(folder.error().find("cannot be read as SOFA") != std::string::npos);
    }
    RandomStream random(3);
    int refused = 0;
    for (int i = 0; i < 100; ++i) {
        std::string damaged = whole;
        // Most structures of the file precede its values.
        for (int k = 0; k < 4; ++k)
            damaged[random.bits() % std::min<std::size_t>(whole.size(), 4096)] =
                static_cast<char>(random.bits());
        put(damaged);
        refused += folder.error() != "none" ? 1 : 0;
    }
    CHECK(refused > 10);  // the damage has an effect
}

TEST_CASE("a direction equally far from more measurements than are interpolated has their level") {
    // A circle of 360 measurements around +x. Their distances differ by rounding only: the weights
    // are zero if more than the interpolated ones round to the smallest distance.
    DirectivityMeasurements circle;
    circle.frequencies_hz = {1000};
    for (int degree = 0; degree < 360; ++degree) {
        circle.positions.push_back({0, std::cos(degree * kPi / 180), std::sin(degree * kPi / 180)});
        circle.energies.push_back(2);
    }
    const Directivity directivity = directivity_of(circle);
    // Relative to the mean over the sphere, to the rounding of the table.
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.6F, 0, 0.8F)})
        CHECK(directivity.factor(d)[4] == Approx(1).epsilon(1e-5));
}
