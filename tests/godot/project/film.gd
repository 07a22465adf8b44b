extends Node
## The house, saved as a scene. Arguments: shut, open, moving: from 0.2 s to 1.2 s, or rebuilt: the
## same house again after 0.5 s.

@onready var house: AulaRoom = $House
var mode := "shut"
var seconds := 0.0
var is_rebuilt := false


func _ready() -> void:
	mode = OS.get_cmdline_user_args()[0]
	if mode == "open":
		$House/Door.rotation.y = 1.6
	await get_tree().process_frame
	if not house.save_scene("res://film.json"):
		get_tree().quit(1)


func _process(delta: float) -> void:
	seconds += delta
	if mode == "moving":
		$House/Door.rotation.y = 1.6 * clampf(seconds - 0.2, 0, 1)
	if mode == "rebuilt" and seconds > 0.5 and not is_rebuilt:
		is_rebuilt = true
		house.rebuild()
