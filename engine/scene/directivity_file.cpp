#include <cmath>

#include "aula/engine/directivity.h"
#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/scene/directivity_measurements.h"
#include "process/regular_file.h"

namespace aula {

namespace {

/// Of a table in JSON: eight bands of the largest, of 30 characters a number.
constexpr std::uint64_t kMaxBytes = std::uint64_t{64} << 20U;

/// Every half degree.
constexpr std::size_t kMaxElevations = 361;
constexpr std::size_t kMaxAzimuths = 720;

/// Reads one band of a table to `energy`, whose size the first band determines.
void read_band(const JsonReader& json, std::size_t band, std::size_t& azimuths,
               std::vector<Bands>& energy) {
    constexpr const char* kRows = "a list of elevations from -90 to 90 degrees";
    constexpr const char* kColumns = "a list of levels in dB, one for each azimuth";
    constexpr NumberRange kLevel_db{-300, 300, true, "decibels from -300 to 300"};
    const auto rows = json.items(kRows);
    if (band == 0 && !rows.empty()) {
        azimuths = rows[0].items(kColumns).size();
        if (rows.size() > kMaxElevations || azimuths > kMaxAzimuths) {
            json.fail("a table of " + std::to_string(rows.size()) + " elevations and " +
                      std::to_string(azimuths) + " azimuths; expected at most " +
                      std::to_string(kMaxElevations) + " and " + std::to_string(kMaxAzimuths));
        }
        energy.resize(rows.size() * azimuths);
    }
    if (azimuths == 0 || rows.size() != energy.size() / azimuths) {
        json.fail("a list of " + std::to_string(rows.size()) +
                  "; expected as many elevations as in the first band");
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const auto columns = rows[r].items(kColumns);
        if (columns.size() != azimuths) {
            rows[r].fail("a list of " + std::to_string(columns.size()) +
                         "; expected as many azimuths as in the first row");
        }
        for (std::size_t c = 0; c < azimuths; ++c) {
            const double level_db = columns[c].number(kLevel_db);
            energy[r * azimuths + c][band] = static_cast<float>(std::pow(10, level_db / 10));
        }
    }
}

Directivity read_table(const JsonReader& json) {
    json.allow_keys({"aula_directivity", "level_db", "source"});
    constexpr NumberRange kVersion{1, 1, true, "1, the version of the format"};
    json.require("aula_directivity", kVersion.expected).number(kVersion);
    json.read("source", [](const JsonReader& x) { x.string("a text"); });
    constexpr const char* kBands = "a list of 8 tables, 63 Hz to 8 kHz";
    const JsonReader levels = json.require("level_db", kBands);
    const auto bands = levels.items(kBands);
    if (bands.size() != kBandCount)
        levels.fail("a list of " + std::to_string(bands.size()) + "; expected " + kBands);
    std::size_t azimuths = 0;
    std::vector<Bands> energy;
    for (std::size_t b = 0; b < kBandCount; ++b) read_band(bands[b], b, azimuths, energy);
    try {
        const std::size_t elevations = energy.size() / azimuths;
        return Directivity::table(elevations, azimuths, std::move(energy));
    } catch (const InputError& error) {
        levels.fail(error.what());
    }
}

}  // namespace

Directivity load_directivity(const std::filesystem::path& file) {
    if (file.extension() == ".sofa") return read_sofa_directivity(file);
    const std::string text =
        read_regular_file(file, kMaxBytes, "a SOFA or JSON file of a directivity");
    const std::string name = file.string();
    const JsonValue json = parse_json(text, name);
    return read_table(JsonReader(json, name));
}

}  // namespace aula
