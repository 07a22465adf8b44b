-- Loads the session in SESSION with buffers of BUFFER samples and prints the first controls of the
-- plugin. Exports SAMPLES samples to BUFFER_1.wav, ..., one for each of TAKES, in the folder FOLDER.
-- Saves the session and closes it.
local buffer = os.getenv("BUFFER")
AudioEngine:set_backend("None (Dummy)", "", ""):set_buffer_size(tonumber(buffer))
local session = load_session(os.getenv("SESSION"), "session")
local track = session:route_by_name("voice")
local plugin = track:nth_plugin(0)
local ports = "ports:"
for i = 0, 14 do
    ports = ports .. string.format(" %.3g", (ARDOUR.LuaAPI.get_processor_param(plugin, i, true)))
end
io.write(ports, "\n")
for channel = 0, 1 do
    local output = track:output():audio(channel)
    local connected = output:connected() or output:connect("Master/audio_in " .. (channel + 1)) == 0
    assert(connected)
end
for take = 1, tonumber(os.getenv("TAKES")) do
    local export = session:simple_export()
    export:set_name(buffer .. "_" .. take)
    export:set_folder(os.getenv("FOLDER"))
    assert(export:set_preset("11111111-2222-4333-8444-555555555555")) -- float.preset
    export:set_range(0, tonumber(os.getenv("SAMPLES")))
    assert(export:run_export())
end
session:save_state("")
io.write("exported\n")
io.stdout:flush() -- Ardour may crash while it closes the session
session, track, plugin = nil, nil, nil
collectgarbage()
close_session()
quit()
