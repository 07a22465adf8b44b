#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

#include "apps/aula/commands.h"
#include "apps/output/printable.h"
#include "aula/engine/material_library.h"
#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/model/material_search.h"

namespace aula {

namespace {

using Library = std::vector<LibraryMaterial>;

std::vector<std::string> names_of(const Library& library) {
    std::vector<std::string> names;
    for (const LibraryMaterial& entry : library) names.push_back(entry.material.name);
    return names;
}

[[noreturn]] void fail_unknown(const std::string& name, const Library& library) {
    throw InputError("materials", "",
                     "no material " + quoted(name) + did_you_mean(name, names_of(library)) +
                         "; expected a name that aula materials list prints");
}

/// Prints band values as whole numbers of a unit, each with a bar of up to 40 characters.
void print_curve(const char* label, const Bands& values, float full, const char* unit) {
    std::printf("%s\n", label);
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const auto value = static_cast<double>(values[band]);
        const std::string bar(static_cast<std::size_t>(40 * value / static_cast<double>(full)),
                              '#');
        std::printf("  %5.0f Hz %3ld %s |%s\n", static_cast<double>(kBandCentres_hz[band]),
                    std::lround(value), unit, bar.c_str());
    }
}

void show_material(const std::string& name, const Library& library) {
    const auto entry = std::find_if(library.begin(), library.end(),
                                    [&](const auto& known) { return known.material.name == name; });
    if (entry == library.end()) fail_unknown(name, library);
    std::printf("%s\n%s\n", name.c_str(), entry->source.c_str());
    print_curve("absorption", entry->material.absorption * 100, 100, "%");
    print_curve("scattering", entry->material.scattering * 100, 100, "%");
    if (entry->material.sound_reduction_db)
        print_curve("sound reduction index", *entry->material.sound_reduction_db,
                    Material::kHighestSoundReduction_db, "dB");
}

/// A line of absorption coefficients for each material; 76 columns.
void print_table(const Library& library) {
    std::printf("%-36s   63  125  250  500   1k   2k   4k   8k\n", "absorption, octaves in Hz");
    for (const LibraryMaterial& entry : library) {
        std::printf("%-36s", entry.material.name.c_str());
        for (const float alpha : entry.material.absorption.value)
            std::printf(" %4.2f", static_cast<double>(alpha));
        std::printf("\n");
    }
}

}  // namespace

int list_materials(const Arguments& arguments) {
    const Library library = material_library();
    if (arguments.material) {
        show_material(*arguments.material, library);
        return 0;
    }
    const MaterialSearch search(arguments.material_word.value_or(""));
    Library listed;
    std::copy_if(library.begin(), library.end(), std::back_inserter(listed),
                 [&](const LibraryMaterial& entry) { return search.finds(entry); });
    if (listed.empty()) fail_unknown(*arguments.material_word, library);
    print_table(listed);
    std::printf("aula materials show NAME prints scattering, sound reduction and sources.\n");
    return 0;
}

}  // namespace aula
