extends Label
## What the room costs, twice a second.

@export var room: AulaRoom


func _ready() -> void:
	var timer := Timer.new()
	timer.wait_time = 0.5
	timer.autostart = true
	timer.timeout.connect(show_costs)
	add_child(timer)


func show_costs() -> void:
	text = "W A S D, mouse, E: door\npropagation frame %.1f of %.1f ms, audio thread %.1f %%" % [
		room.frame_ms, room.frame_period_ms, room.audio_load_percent]
