#include "engine/model/material_guess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace aula {

namespace {

/// Words that mean a material of the library, separated by blanks: lower case, without accents.
struct Words {
    const char* material;
    const char* words;
};

// English, German, French, Spanish.
constexpr std::array kMaterials{
    Words{"acoustic_ceiling", "rasterdecke akustikdecke"},
    Words{"acoustic_plaster", "akustikputz acousticplaster"},
    Words{"acoustic_tile",
          "acoustic akustik acoustique acustico absorber absorbeur absorbente ecophon armstrong"},
    Words{"asphalt", "asphalt asphalte asfalto bitumen tarmac teer goudron"},
    Words{"audience", "audience publikum public publico gestuhl zuschauer spectateur people crowd"},
    Words{"bookshelf",
          "bookshelf bookcase books bucher bucherregal bibliotheque libros estanteria"},
    Words{"brick", "brick bricks ziegel backstein klinker brique ladrillo mauerwerk masonry"},
    Words{"carpet",
          "carpet teppich teppichboden teppichfliese teppichfliesen moquette tapis alfombra "
          "moqueta rug auslegware"},
    Words{"concrete", "concrete beton hormigon cement zement ciment cemento screed estrich"},
    Words{"concrete_block", "cinderblock concreteblock breezeblock parpaing"},
    Words{"cork", "cork kork corcho"},
    Words{"curtain",
          "curtain vorhang rideau cortina drape drapery gardine fabric stoff textile textil cloth "
          "tissu tela tapestry"},
    Words{"double_glazing", "doubleglazing isolierverglasung isolierglas doublevitrage"},
    Words{"felt", "felt filz feutre fieltro"},
    Words{"foam", "foam schaum schaumstoff mousse espuma basotect"},
    Words{
        "foliage",
        "foliage leaves leaf plant tree hedge bush pflanze baum hecke feuillage arbre arbol hoja"},
    Words{"glass",
          "glass glas verre vidrio glazing verglasung vitrage cristal plexiglas acrylic perspex"},
    Words{"grass", "grass gras rasen lawn pelouse gazon cesped herbe hierba"},
    Words{"gravel", "gravel kies gravier grava"},
    Words{"gypsum_board",
          "gypsum drywall plasterboard gipskarton rigips sheetrock placoplatre pladur trockenbau"},
    Words{"leather_seats", "leather leder cuir cuero"},
    Words{"limestone", "limestone kalkstein calcaire caliza"},
    Words{"linoleum", "linoleum lino vinyl pvc"},
    Words{"marble", "marble marmor marbre marmol"},
    Words{"metal",
          "metal metall steel stahl iron eisen acier acero alu aluminium aluminum aluminio copper "
          "kupfer cuivre brass messing laiton chrome inox blech tole"},
    Words{"mineral_wool", "mineralwool mineralwolle rockwool glasswool insulation dammung"},
    Words{"mirror", "mirror spiegel miroir espejo"},
    Words{"parquet", "parquet parkett laminate laminat tarima"},
    Words{"plaster",
          "plaster putz verputz kalkzementputz zementputz platre yeso gips stucco stuck enduit "
          "tapete wallpaper paint painted "
          "farbe peinture pintura"},
    Words{"perforated_gypsum", "lochgips lochgipsplatte"},
    Words{"perforated_metal_ceiling", "lochblech lochblechdecke"},
    Words{"plywood", "plywood sperrholz contreplaque contrachapado"},
    Words{"rough_concrete", "rohbeton sichtbeton betonbrut"},
    Words{"rubber", "rubber gummi caoutchouc goma"},
    Words{"sand", "sand sable arena"},
    Words{"snow", "snow schnee neige nieve"},
    Words{"soil", "soil dirt erde terre tierra mud"},
    Words{"stone",
          "stone stein pierre piedra granite granit granito slate schiefer ardoise sandstone "
          "sandstein rock fels roche"},
    Words{"terrazzo", "terrazzo"},
    Words{"tile",
          "tile tiles fliese fliesen kachel carrelage azulejo baldosa ceramic ceramique ceramica "
          "keramik porcelain"},
    Words{"upholstered_seats",
          "upholstered upholstery polster cushion sofa couch armchair sessel fauteuil butaca "
          "canape mattress matratze pillow kissen coussin"},
    Words{"velvet_curtain", "velvet samt velours terciopelo"},
    Words{"water", "water wasser eau agua"},
    Words{"wood",
          "wood wooden holz bois madera timber oak eiche chene roble pine kiefer walnut nussbaum "
          "beech buche hetre maple ahorn cherry birch birke teak mahogany mdf chipboard spanplatte "
          "plank bretter planche"},
    Words{"wood_floor", "woodfloor woodenfloor hardwood holzboden dielen floorboard plancher"},
    Words{"wood_panel", "panelling paneling vertafelung lambris wainscot"},
    Words{"wood_wool", "woodwool holzwolle heraklith"},
};

// Parts of a building and furniture, of what they usually consist of.
constexpr std::array kParts{
    Words{"brick", "facade fassade fachada"},
    Words{"concrete", "column saule pillar colonne columna pilier"},
    Words{"concrete", "stair stairs treppe escalier escalera"},
    Words{"door", "door doors tur turen turblatt porte puerta"},
    Words{"metal", "tafel whiteboard blackboard pizarra radiator heizkorper radiateur"},
    Words{"organ_pipes", "organ orgel orgue organo"},
    Words{"partition_office_screen", "stellwand stellwande"},
    Words{"plaster", "wall walls wand wande mur murs pared paredes muro paroi mauer"},
    Words{"plaster", "ceiling decke plafond techo vault gewolbe voute boveda paper papier papel"},
    Words{"stone", "altar autel"},
    Words{"roof_boards", "roof dach toit toiture tejado"},
    Words{"stage_floor", "stage buhne escenario"},
    Words{"upholstered_seats", "seat seats seating sitz siege asiento bed bett"},
    Words{"window", "window windows fenster fenetre ventana"},
    Words{"wood",
          "table tisch desk pult mobel meuble furniture cabinet schrank armoire mesa armario"},
    Words{"wood_floor", "floor floors boden fussboden sol suelo"},
    Words{"wooden_chairs", "chair chairs stuhl stuhle chaise silla"},
    Words{"wooden_pews", "pew pews bench kirchenbank banc banco"},
};

constexpr const char* kHorizontal =
    "floor floors boden fussboden sol suelo ceiling decke plafond techo carpet teppich moquette "
    "tapis alfombra parquet parkett linoleum laminat tarima";

/// The base letter of a letter of Latin-1 in UTF-8, whose second byte is given; 0 if it has none.
char base_letter(unsigned char second) {
    constexpr std::string_view kLower = "aaaaaaaceeeeiiii-nooooo-ouuuuy-s";  // from U+00C0 on
    constexpr unsigned kFirst = 0x80;
    constexpr unsigned kSharpS = 0x9f;
    if (second == kSharpS) return 's';
    const unsigned place = (second - kFirst) % 32;
    return kLower[place] == '-' ? '\0' : kLower[place];
}

/// The words of a name in lower case without accents: divided at anything but letters and before
/// capitals. "ae", "oe" and "ue" become "a", "o" and "u", as German writes umlauts.
std::vector<std::string> words_of(std::string_view name) {
    std::vector<std::string> words(1);
    bool was_lower = false;
    const auto add = [&](char letter) { words.back() += letter; };
    const auto divide = [&] {
        if (!words.back().empty()) words.emplace_back();
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto c = static_cast<unsigned char>(name[i]);
        const bool has_next = i + 1 < name.size();
        if (c == 0xc3 && has_next) {
            constexpr unsigned kFirstLower = 0x9f;  // the sharp s
            const auto second = static_cast<unsigned char>(name[++i]);
            const bool is_lower = second >= kFirstLower;
            if (!is_lower && was_lower) divide();
            was_lower = is_lower;
            if (const char letter = base_letter(second); letter != '\0') add(letter);
        } else if (c < 0x80 && std::isalpha(c) != 0) {
            if (std::isupper(c) != 0 && was_lower) divide();
            was_lower = std::islower(c) != 0;
            const char letter = static_cast<char>(std::tolower(c));
            const std::string& word = words.back();
            const bool is_umlaut = letter == 'e' && !word.empty() &&
                                   std::string_view("aou").find(word.back()) != std::string::npos;
            if (!is_umlaut) add(letter);
        } else {
            was_lower = false;
            divide();
        }
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

/// Whether a word of a name means `known`. Short words are parts of many others, such as "tur" of
/// "texture": those of at most three letters must be whole words, those of four begin or end one.
bool means(std::string_view word, std::string_view known) {
    constexpr std::size_t kWhole = 3;
    constexpr std::size_t kEnds = 4;
    if (known.size() <= kWhole) return word == known;
    if (known.size() <= kEnds) return word.starts_with(known) || word.ends_with(known);
    return word.find(known) != std::string_view::npos;
}

/// Calls `use` with each of the words of a list.
template <typename Use>
void for_each_word(std::string_view list, const Use& use) {
    while (!list.empty()) {
        const std::size_t end = std::min(list.find(' '), list.size());
        use(list.substr(0, end));
        list.remove_prefix(std::min(end + 1, list.size()));
    }
}

/// The entry with the longest word that the name means; of equally long ones the last in the name,
/// which in German is the head of a compound.
std::optional<MaterialGuess> longest(const std::vector<std::string>& words,
                                     std::span<const Words> table) {
    std::string joined;
    for (const std::string& word : words) joined += word;
    std::optional<MaterialGuess> best;
    std::size_t best_at = 0;
    for (const Words& entry : table) {
        for_each_word(entry.words, [&](std::string_view listed) {
            // As the names are written.
            const std::string known = words_of(listed).front();
            const bool found = std::any_of(words.begin(), words.end(),
                                           [&](const std::string& w) { return means(w, known); });
            // Long ones may be written in several words: "oak floor board".
            constexpr std::size_t kJoined = 8;
            const std::size_t at = joined.rfind(known);
            if (!found && (known.size() < kJoined || at == std::string::npos)) return;
            if (best && (listed.size() < best->word.size() ||
                         (listed.size() == best->word.size() && at <= best_at)))
                return;
            best = {entry.material, std::string(listed)};
            best_at = at;
        });
    }
    return best;
}

}  // namespace

MaterialGuess guess_material(const std::string& name) {
    const std::vector<std::string> words = words_of(name);
    if (const auto material = longest(words, kMaterials)) return *material;
    if (const auto part = longest(words, kParts)) return *part;
    return {"plaster", ""};
}

bool names_horizontal_part(const std::string& name) {
    const std::array table{Words{"", kHorizontal}};
    return longest(words_of(name), table).has_value();
}

}  // namespace aula
