#include "aula/engine/material_library.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

TEST_CASE("the material library has at least 40 materials, each named once and with its source") {
    const auto library = aula::material_library();
    CHECK(library.size() >= 40);
    std::set<std::string> names;
    for (const auto& [material, source] : library) {
        INFO(material.name);
        CHECK(names.insert(material.name).second);
        CHECK(source.find("absorption: ") != std::string::npos);
        CHECK(source.find("scattering: ") != std::string::npos);
    }
}

TEST_CASE("the material library has the materials that the scene format promises") {
    const auto library = aula::material_library();
    for (const char* name :
         {"plaster", "wood", "concrete", "brick", "glass", "carpet", "curtain", "marble", "tile",
          "gypsum_board", "door", "audience", "limestone", "metal", "grass", "water"}) {
        INFO(name);
        CHECK(std::any_of(library.begin(), library.end(),
                          [&](const auto& entry) { return entry.material.name == name; }));
    }
}

TEST_CASE("all coefficients of the material library are within 0 to 1") {
    for (const auto& [material, source] : aula::material_library()) {
        INFO(material.name);
        for (std::size_t b = 0; b < aula::kBandCount; ++b) {
            CHECK((material.absorption[b] >= 0 && material.absorption[b] <= 1));
            CHECK((material.scattering[b] >= 0 && material.scattering[b] <= 1));
        }
    }
}

TEST_CASE("partitions of the library state where their sound reduction is from and absorb more") {
    int partitions = 0;
    for (const auto& [material, source] : aula::material_library()) {
        INFO(material.name);
        const bool transmits = material.sound_reduction_db.has_value();
        CHECK(transmits == material.name.starts_with("partition_"));
        CHECK(transmits == (source.find("; sound reduction: ") != std::string::npos));
        if (!transmits) continue;
        ++partitions;
        for (std::size_t b = 0; b < aula::kBandCount; ++b) {
            INFO("band " << b);
            CHECK_FALSE(material.transmits_too_much(b));
            const float reduction_db = (*material.sound_reduction_db)[b];
            CHECK((reduction_db >= 5 && reduction_db <= 65));
        }
    }
    CHECK(partitions >= 15);
}

TEST_CASE("a carpet absorbs treble, a marble floor almost nothing, an audience almost everything") {
    const auto library = aula::material_library();
    const auto absorption = [&](const std::string& name) {
        return std::find_if(library.begin(), library.end(),
                            [&](const auto& entry) { return entry.material.name == name; })
            ->material.absorption;
    };
    CHECK(absorption("carpet")[0] < 0.1F);
    CHECK(absorption("carpet")[6] > 0.3F);
    CHECK(absorption("marble").max() < 0.05F);
    CHECK(absorption("audience")[4] > 0.8F);
}
