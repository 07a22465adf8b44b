// A program that reads a SOFA file of directivities (FreeFieldDirectivityTF) from standard input
// and writes a DirectivityHeader and the measurements to standard output. It is embedded in the
// library and run by read_sofa_directivity().

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/directivity_stream.h"
#include "process/contained_program.h"

namespace {

using namespace aula;
using Verdict = DirectivityHeader::Verdict;

/// The process ends soon: identifiers of HDF5 are not closed.
struct Values {
    std::vector<hsize_t> sizes;
    std::vector<double> values;
    std::string type;  ///< the attribute Type
};

std::string text_attribute(hid_t object, const char* name) {
    constexpr std::size_t kLongest = 4096;
    const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    if (attribute < 0 || H5Sget_simple_extent_npoints(H5Aget_space(attribute)) != 1) return {};
    const hid_t type = H5Aget_type(attribute);
    if (H5Tget_class(type) != H5T_STRING) return {};
    if (H5Tis_variable_str(type) > 0) {
        char* text = nullptr;
        if (H5Aread(attribute, type, &text) < 0 || text == nullptr) return {};
        return text;
    }
    const std::size_t size = H5Tget_size(type);
    if (size > kLongest) return {};
    std::string text(size, '\0');
    if (H5Aread(attribute, type, text.data()) < 0) return {};
    return text.substr(0, text.find('\0'));
}

/// A numeric variable of 1 to 3 dimensions; empty if there is none of that name.
std::optional<Values> variable(hid_t file, const char* name) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    if (set < 0) return std::nullopt;
    const hid_t space = H5Dget_space(set);
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 1 || rank > 3) return std::nullopt;
    Values read;
    read.sizes.resize(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, read.sizes.data(), nullptr);
    hsize_t count = 1;
    for (const hsize_t size : read.sizes) {
        if (size == 0 || size > DirectivityHeader::kMaxValues) return std::nullopt;
        count *= size;
        if (count > DirectivityHeader::kMaxValues) return std::nullopt;
    }
    read.values.resize(count);
    if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, read.values.data()) < 0)
        return std::nullopt;
    read.type = text_attribute(set, "Type");
    return read;
}

/// The sizes of a variable; empty if there is none of that name.
std::vector<hsize_t> sizes_of(hid_t file, const char* name) {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    if (set < 0) return {};
    hsize_t sizes[H5S_MAX_RANK];
    const int rank = H5Sget_simple_extent_dims(H5Dget_space(set), sizes, nullptr);
    return rank < 0 ? std::vector<hsize_t>{} : std::vector<hsize_t>(sizes, sizes + rank);
}

bool answer(Verdict verdict) {
    DirectivityHeader header;
    header.verdict = verdict;
    return write(header);
}

/// Reads the first three numbers of an optional vector.
bool read_axis(hid_t file, const char* name, std::array<double, 3>& axis) {
    if (sizes_of(file, name).empty()) return true;
    const auto values = variable(file, name);
    if (!values || values->sizes.size() < 2 || values->sizes[1] != 3) return false;
    if (values->type == "spherical") return false;
    std::copy_n(values->values.begin(), 3, axis.begin());
    return true;
}

bool run() {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    H5PLset_loading_state(0);
    const hid_t file = H5Fopen("/proc/self/fd/0", H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) return answer(Verdict::unreadable);
    // No other file is opened.
    const rlimit none{0, 0};
    setrlimit(RLIMIT_NOFILE, &none);
    if (text_attribute(file, "SOFAConventions") != "FreeFieldDirectivityTF")
        return answer(Verdict::other_kind);

    const std::vector<hsize_t> sizes = sizes_of(file, "Data.Real");
    if (sizes.size() != 3 || sizes != sizes_of(file, "Data.Imag"))
        return answer(Verdict::incomplete);
    const auto [measurements, directions, frequencies] = std::array{sizes[0], sizes[1], sizes[2]};
    constexpr hsize_t kMax = DirectivityHeader::kMaxValues;
    if (directions > DirectivityHeader::kMaxDirections ||
        frequencies > DirectivityHeader::kMaxFrequencies || measurements > kMax ||
        measurements * directions > kMax || measurements * directions * frequencies > kMax)
        return answer(Verdict::too_large);
    const auto real = variable(file, "Data.Real");
    const auto imaginary = variable(file, "Data.Imag");
    const auto frequency = variable(file, "N");
    const auto position = variable(file, "ReceiverPosition");
    DirectivityHeader header;
    if (!real || !imaginary || !frequency || frequency->values.size() != frequencies || !position ||
        position->sizes.size() < 2 || position->sizes[0] != directions || position->sizes[1] != 3 ||
        !read_axis(file, "SourceView", header.view) || !read_axis(file, "SourceUp", header.up))
        return answer(Verdict::incomplete);
    if (position->type != "spherical" && position->type != "cartesian")
        return answer(Verdict::other_kind);

    // Coordinates and axes of the first measurement apply to all.
    const std::size_t stride = position->sizes.size() == 3 ? position->sizes[2] : 1;
    std::vector<double> coordinates;
    for (std::size_t i = 0; i < 3 * directions; ++i)
        coordinates.push_back(position->values[i * stride]);
    std::vector<double> energies(directions * frequencies);
    for (std::size_t i = 0; i < real->values.size(); ++i) {
        const double re = real->values[i];
        const double im = imaginary->values[i];
        energies[i % energies.size()] += re * re + im * im;
    }
    header.verdict = Verdict::usable;
    header.directions = static_cast<std::uint32_t>(directions);
    header.frequencies = static_cast<std::uint32_t>(frequencies);
    header.spherical = position->type == "spherical" ? 1 : 0;
    return write(header) && write(coordinates) && write(frequency->values) && write(energies);
}

}  // namespace

int main() {
    limit_resources();
    return run() && std::fflush(stdout) == 0 ? 0 : 1;
}
