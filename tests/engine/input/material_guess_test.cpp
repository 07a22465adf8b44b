#include "engine/input/material_guess.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "aula/engine/material_library.h"

using namespace aula;

TEST_CASE("Names of four languages, layers and copies mean the materials that people mean") {
    const std::vector<std::pair<std::string, std::string>> expected{
        {"Oak_Floorboards", "wood_floor"},
        {"Wall_Plaster", "plaster"},
        {"brick wall", "brick"},
        {"Concrete.002", "concrete"},
        {"Kunststoff schwarz", "linoleum"},
        {"Arch|Layer 3|RedBrick", "brick"},
        {"M_GlassFront", "glass"},
        {"hardwood", "wood_floor"},
        {"Wand_Putz", "plaster"},
        {"Fußboden", "wood_floor"},
        {"Da\xcc\x88mmung", "mineral_wool"},
        {"Rueckwand_Akustik", "acoustic_tile"},
        {"Rückwand_Akustik", "acoustic_tile"},
        {"Gestühl", "audience"},
        {"Holztür", "wood"},
        {"Türen_Holz", "door"},
        {"Glastür", "glass"},
        {"Wand_GK", "gypsum_board"},
        {"Deckensegel", "acoustic_tile"},
        {"Wandpaneel_Holz_geschlitzt", "wood_panel"},
        {"Decke_Akustik_Lochplatte", "perforated_gypsum"},
        {"Schreibplatte_HPL", "wood"},
        {"Teppichfliesen grau", "carpet"},
        {"Akustikputz", "acoustic_plaster"},
        {"Lochgips Decke", "perforated_gypsum"},
        {"Kalkzementputz", "plaster"},
        {"Isolierverglasung", "double_glazing"},
        {"Odenwald Rasterdecke", "acoustic_ceiling"},
        {"Stellwand_anthrazit", "partition_office_screen"},
        {"Türblatt", "door"},
        {"Tür", "door"},
        {"TÜR", "door"},
        {"Fensterglas", "glass"},
        {"Decke", "plaster"},
        {"Eichenholz", "wood"},
        {"béton brut", "rough_concrete"},
        {"Plâtre", "plaster"},
        {"moquette_bleue", "carpet"},
        {"bois clair", "wood"},
        {"Hormigón", "concrete"},
        {"pared de ladrillo", "brick"},
        {"azulejo_blanco", "tile"},
        {"Textile_Blue", "curtain"},
        {"ventana", "window"},
        {"Water", "water"}};
    for (const auto& [name, material] : expected) {
        CAPTURE(name);
        const MaterialGuess guess = guess_material(name);
        CHECK(guess.material == material);
        CHECK_FALSE(guess.word.empty());
    }
}

TEST_CASE("A name without a known word is plaster, and short words are not found within others") {
    for (const std::string name : {"", "Material", "Mat.003", "texture_04", "Structure",
                                   "DefaultMaterial", "\xff\xc3", "\xc3", "ß", "Furniture2x"}) {
        CAPTURE(name);
        const MaterialGuess guess = guess_material(name);
        if (name == "Furniture2x") {
            CHECK(guess.material == "wood");
        } else {
            CHECK(guess.material == "plaster");
            CHECK(guess.word.empty());
        }
    }
}

TEST_CASE("Each material that is guessed is in the library") {
    const auto library = material_library();
    // The names of the library are names of models, too.
    for (const LibraryMaterial& entry : library) {
        const std::string guess = guess_material(entry.material.name).material;
        CAPTURE(entry.material.name, guess);
        CHECK(std::any_of(library.begin(), library.end(), [&](const LibraryMaterial& other) {
            return other.material.name == guess;
        }));
    }
}
