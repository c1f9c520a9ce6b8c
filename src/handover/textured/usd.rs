//! USD as text (`.usda`), and with its textures in one file (`.usdz`): for Blender, Houdini, Unreal, Maya, Quick Look.
