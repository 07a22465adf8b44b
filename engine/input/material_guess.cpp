#include "engine/input/material_guess.h"

#include <array>
#include <vector>

#include "engine/input/name_words.h"

namespace aula {

namespace {

// English, German, French, Spanish.
constexpr std::array kMaterials{
    NameWords{"acoustic_ceiling", "rasterdecke akustikdecke"},
    NameWords{"acoustic_plaster", "akustikputz acousticplaster"},
    NameWords{
        "acoustic_tile",
        "acoustic akustik acoustique acustico absorber absorbeur absorbente ecophon armstrong "
        "deckensegel baffle"},
    NameWords{"asphalt", "asphalt asphalte asfalto bitumen tarmac teer goudron"},
    NameWords{"audience",
              "audience publikum public publico gestuhl zuschauer spectateur people crowd"},
    NameWords{"bookshelf",
              "bookshelf bookcase books bucher bucherregal bibliotheque libros estanteria"},
    NameWords{"brick", "brick bricks ziegel backstein klinker brique ladrillo mauerwerk masonry"},
    NameWords{"carpet",
              "carpet teppich teppichboden teppichfliese teppichfliesen moquette tapis alfombra "
              "moqueta rug auslegware"},
    NameWords{"concrete", "concrete beton hormigon cement zement ciment cemento screed estrich"},
    NameWords{"concrete_block", "cinderblock concreteblock breezeblock parpaing"},
    NameWords{"cork", "cork kork corcho"},
    NameWords{
        "curtain",
        "curtain vorhang rideau cortina drape drapery gardine fabric stoff textile textil cloth "
        "tissu tela tapestry"},
    NameWords{
        "double_glazing",
        "doubleglazing doppelverglasung doppelfenster isolierverglasung isolierglas doublevitrage"},
    NameWords{"felt", "felt filz feutre fieltro"},
    NameWords{"foam", "foam schaum schaumstoff mousse espuma basotect"},
    NameWords{
        "foliage",
        "foliage leaves leaf plant tree hedge bush pflanze baum hecke feuillage arbre arbol hoja"},
    NameWords{
        "glass",
        "glass glas verre vidrio glazing verglasung vitrage cristal plexiglas acrylic perspex"},
    NameWords{"grass", "grass gras rasen lawn pelouse gazon cesped herbe hierba"},
    NameWords{"gravel", "gravel kies gravier grava"},
    NameWords{"gypsum_board",
              "gypsum drywall plasterboard gipskarton gk gkb gkf rigips sheetrock placoplatre "
              "pladur trockenbau"},
    NameWords{"leather_seats", "leather leder cuir cuero"},
    NameWords{"limestone", "limestone kalkstein calcaire caliza"},
    NameWords{"linoleum", "linoleum lino vinyl pvc plastic plastik kunststoff plastique plastico"},
    NameWords{"marble", "marble marmor marbre marmol"},
    NameWords{
        "metal",
        "metal metall steel stahl iron eisen acier acero alu aluminium aluminum aluminio copper "
        "kupfer cuivre brass messing laiton chrome inox blech tole"},
    NameWords{"mineral_wool", "mineralwool mineralwolle rockwool glasswool insulation dammung"},
    NameWords{"mirror", "mirror spiegel miroir espejo"},
    NameWords{"parquet", "parquet parkett laminate laminat tarima"},
    NameWords{"plaster",
              "plaster putz verputz kalkzementputz zementputz platre yeso gips stucco stuck enduit "
              "tapete wallpaper paint painted "
              "farbe peinture pintura"},
    NameWords{"perforated_gypsum", "lochgips lochgipsplatte lochplatte lochdecke"},
    NameWords{"perforated_metal_ceiling", "lochblech lochblechdecke"},
    NameWords{"plywood", "plywood sperrholz contreplaque contrachapado"},
    NameWords{"rough_concrete", "rohbeton sichtbeton betonbrut"},
    NameWords{"rubber", "rubber gummi caoutchouc goma"},
    NameWords{"sand", "sand sable arena"},
    NameWords{"snow", "snow schnee neige nieve"},
    NameWords{"soil", "soil dirt erde terre tierra mud"},
    NameWords{"stone",
              "stone stein pierre piedra granite granit granito slate schiefer ardoise sandstone "
              "sandstein rock fels roche"},
    NameWords{"terrazzo", "terrazzo"},
    NameWords{
        "tile",
        "tile tiles fliese fliesen kachel carrelage azulejo baldosa ceramic ceramique ceramica "
        "keramik porcelain"},
    NameWords{"upholstered_seats",
              "upholstered upholstery polster cushion sofa couch armchair sessel fauteuil butaca "
              "canape mattress matratze pillow kissen coussin"},
    NameWords{"velvet_curtain", "velvet samt velours terciopelo"},
    NameWords{"water", "water wasser eau agua"},
    NameWords{
        "wood",
        "wood wooden holz bois madera timber oak eiche chene roble pine kiefer walnut nussbaum "
        "beech buche hetre hpl maple ahorn cherry birch birke teak mahogany mdf chipboard "
        "spanplatte "
        "plank bretter planche"},
    NameWords{"wood_floor", "woodfloor woodenfloor hardwood holzboden dielen floorboard plancher"},
    NameWords{"wood_panel", "panelling paneling paneel wandpaneel vertafelung lambris wainscot"},
    NameWords{"wood_wool", "woodwool holzwolle heraklith"},
};

// Parts of a building and furniture, of what they usually consist of.
constexpr std::array kParts{
    NameWords{"brick", "facade fassade fachada"},
    NameWords{"concrete", "column saule pillar colonne columna pilier"},
    NameWords{"concrete", "stair stairs treppe escalier escalera"},
    NameWords{"door", "door doors tur turen turblatt porte puerta"},
    NameWords{"metal", "tafel whiteboard blackboard pizarra radiator heizkorper radiateur"},
    NameWords{"organ_pipes", "organ orgel orgue organo"},
    NameWords{"partition_office_screen", "stellwand stellwande"},
    NameWords{"plaster", "wall walls wand wande mur murs pared paredes muro paroi mauer"},
    NameWords{"plaster",
              "ceiling decke plafond techo vault gewolbe voute boveda paper papier papel"},
    NameWords{"stone", "altar autel"},
    NameWords{"roof_boards", "roof dach toit toiture tejado"},
    NameWords{"stage_floor", "stage buhne escenario"},
    NameWords{"upholstered_seats", "seat seats seating sitz siege asiento bed bett"},
    NameWords{"window", "window windows fenster fenetre ventana"},
    NameWords{"wood",
              "table tisch desk pult mobel meuble furniture cabinet schrank armoire mesa armario"},
    NameWords{"wood_floor", "floor floors boden fussboden sol suelo"},
    NameWords{"wooden_chairs", "chair chairs stuhl stuhle chaise silla"},
    NameWords{"wooden_pews", "pew pews bench kirchenbank banc banco"},
};

constexpr const char* kHorizontal =
    "floor floors boden fussboden sol suelo ceiling decke plafond techo carpet teppich moquette "
    "tapis alfombra parquet parkett linoleum laminat tarima";

}  // namespace

MaterialGuess guess_material(const std::string& name) {
    const std::vector<std::string> words = words_of(name);
    const auto material = longest_meaning(words, kMaterials);
    const auto part = longest_meaning(words, kParts);
    const auto means = [](const auto& found, const std::string& meaning) {
        return found && found->meaning == meaning;
    };
    const bool is_wooden_door = means(part, "door") && means(material, "wood");
    if (material && !is_wooden_door) return {material->meaning, material->word};
    if (part) return {part->meaning, part->word};
    return {"plaster", ""};
}

bool names_horizontal_part(const std::string& name) {
    const std::array table{NameWords{"", kHorizontal}};
    return longest_meaning(words_of(name), table).has_value();
}

}  // namespace aula
