-- Writes and closes the session in SESSION: a track with voice.wav as its region, and the plugin
-- PLUGIN of the type TYPE (LV2, VST3) with the preset PRESET, if any, and VALUES, as "9=-3 14=0";
-- without values there is automation of source_x over three seconds.
local folder = os.getenv("SESSION")
os.execute("rm -rf '" .. folder .. "'")
AudioEngine:set_backend("None (Dummy)", "", "")
local session = create_session(folder, "session", 48000)
local track = session:new_audio_track(1, 2, nil, 1, "voice", ARDOUR.PresentationInfo.max_order,
                                      ARDOUR.TrackMode.Normal, true):front()
local plugin = ARDOUR.LuaAPI.new_plugin(session, os.getenv("PLUGIN"),
                                        ARDOUR.PluginType[os.getenv("TYPE")], "")
assert(track:add_processor_by_index(plugin, 0, nil, true) == 0)
local preset = os.getenv("PRESET")
if preset then
    local instance = plugin:to_insert():plugin(0)
    assert(instance:load_preset(instance:preset_by_label(preset)))
end
local values = os.getenv("VALUES")
for parameter, value in (values or ""):gmatch("(%d+)=(%S+)") do
    assert(ARDOUR.LuaAPI.set_processor_param(plugin, tonumber(parameter), tonumber(value)))
end
if not values then
    local _, points = ARDOUR.LuaAPI.plugin_automation(plugin, 0)
    points:add(Temporal.timepos_t(0), 6.5, false, true)
    points:add(Temporal.timepos_t(3 * 48000), 4.5, false, true)
    local source_x = Evoral.Parameter(ARDOUR.AutomationType.PluginAutomation, 0, 3)
    plugin:to_automatable():automation_control(source_x, false):set_automation_state(
        ARDOUR.AutoState.Play)
end
session:save_state("")

-- Only Ardour's window imports files: the source and the region are written into the session.
local length = 3 * 282240000 -- superclock ticks
local file = io.open(folder .. "/session.ardour")
local text = file:read("a")
file:close()
text = text:gsub("<Sources/>", '<Sources><Source name="voice.wav" type="audio" flags="" ' ..
                 'id="100001" channel="0" origin="" gain="1"/></Sources>')
text = text:gsub('(<Playlist id="%d+" name="voice"[^>]*)/>', '%1><Region name="voice" ' ..
                 'id="100002" type="audio" opaque="1" start="a0" length="a' .. length .. '@a0" ' ..
                 'first-edit="nothing" layering-index="0" source-0="100001" ' ..
                 'master-source-0="100001" channels="1" fade-in-active="0" fade-out-active="0" ' ..
                 'envelope-active="0" scale-amplitude="1"/></Playlist>')
file = io.open(folder .. "/session.ardour", "w")
file:write(text)
file:close()
io.write("created\n")
io.stdout:flush() -- Ardour may crash while it closes the session
session, track, plugin = nil, nil, nil
collectgarbage()
close_session()
quit()
