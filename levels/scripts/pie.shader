// Shaders of the levels in this folder. A picture of the same name is enough for plain surfaces (brick, tiles, wood …);
// here stands what is not plain: what is never drawn, what shines, what light passes, the sky.

// --- never drawn ---

// For sides that nobody sees.
textures/common/caulk
{
	qer_editorimage textures/common/caulk.png
	surfaceparm nodraw
	surfaceparm nomarks
	surfaceparm nolightmap
}

textures/common/nodraw
{
	qer_editorimage textures/common/nodraw.png
	surfaceparm nodraw
	surfaceparm nolightmap
	surfaceparm nonsolid
	surfaceparm trans
}

// The middle of its brush is the point about which a brush entity moves.
textures/common/origin
{
	qer_editorimage textures/common/origin.png
	surfaceparm nodraw
	surfaceparm nolightmap
	surfaceparm nonsolid
	surfaceparm origin
}

// Stops players only.
textures/common/clip
{
	qer_editorimage textures/common/clip.png
	surfaceparm nodraw
	surfaceparm nolightmap
	surfaceparm nonsolid
	surfaceparm trans
	surfaceparm nomarks
	surfaceparm playerclip
}

// --- lamps: panels that shine downwards or wherever they face ---

textures/pie/lamp
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 1 0.96 0.90
	q3map_surfacelight 2000
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 1 0.97 0.90 )
	}
}

// As lamp, half as bright: where there are many of them.
textures/pie/lamp_dim
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 1 0.96 0.90
	q3map_surfacelight 1100
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 1 0.97 0.90 )
	}
}

textures/pie/lamp_warm
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 1 0.82 0.60
	q3map_surfacelight 700
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 1 0.80 0.50 )
	}
}

textures/pie/lamp_cool
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 0.66 0.83 1
	q3map_surfacelight 700
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 0.72 0.88 1 )
	}
}

textures/pie/lamp_red
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 1 0.56 0.46
	q3map_surfacelight 700
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 1 0.42 0.34 )
	}
}

textures/pie/lamp_green
{
	qer_editorimage textures/pie/lamp.png
	q3map_lightRGB 0.72 1 0.74
	q3map_surfacelight 700
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map textures/pie/lamp.png
		rgbGen const ( 0.62 1 0.64 )
	}
}

// The light square of the Cornell box: its published emission at 700, 600 and 500 nm, and no backsplash, so that the
// square alone shines.
textures/pie/cornell_lamp
{
	qer_editorimage textures/pie/cornell_white.png
	q3map_lightRGB 18.4 15.6 8
	q3map_surfacelight 7000
	q3map_backsplash 0 0
	surfaceparm nomarks
	surfaceparm nolightmap
	{
		map $whiteimage
		rgbGen const ( 1 0.93 0.70 )
	}
}

// --- sky ---

// Sun in the south west, 48 degrees up, where the picture has its glow.
textures/pie/sky
{
	qer_editorimage textures/pie/sky_up.png
	q3map_sunExt 1 0.90 0.72 150 235 48 1 8
	q3map_lightRGB 0.60 0.76 1
	q3map_skyLight 60 4
	surfaceparm sky
	surfaceparm noimpact
	surfaceparm nolightmap
	surfaceparm nomarks
	skyParms textures/pie/sky 512 -
}

// --- what light passes ---

// Light goes through it as if it were not there.
textures/pie/glass
{
	qer_editorimage textures/pie/glass.png
	qer_trans 0.4
	surfaceparm trans
	surfaceparm nomarks
	surfaceparm nolightmap
	cull none
	{
		map textures/pie/glass.png
		blendFunc blend
	}
	{
		map textures/pie/mirror.png
		tcGen environment
		blendFunc add
		rgbGen const ( 0.07 0.08 0.08 )
	}
	// later, for caustics: refracts, index 1.5
}

// Coloured by what is painted on it.
textures/pie/stained
{
	qer_editorimage textures/pie/stained.png
	surfaceparm trans
	surfaceparm lightfilter
	surfaceparm nomarks
	surfaceparm nolightmap
	cull none
	{
		map textures/pie/stained.png
		blendFunc filter
	}
	{
		map textures/pie/stained.png
		blendFunc add
		rgbGen const ( 0.35 0.35 0.35 )
	}
}

textures/pie/water
{
	qer_editorimage textures/pie/water.png
	qer_trans 0.5
	surfaceparm trans
	surfaceparm water
	surfaceparm nonsolid
	surfaceparm nomarks
	surfaceparm nolightmap
	cull none
	{
		map textures/pie/water.png
		blendFunc blend
		tcMod turb 0 0.04 0 0.15
		tcMod scroll 0.01 0.02
	}
}

// --- mirrors ---

// Opaque: for light a grey wall, for the eye the picture of a bright sky and a dark floor.
textures/pie/mirror
{
	qer_editorimage textures/pie/mirror.png
	surfaceparm nomarks
	{
		map textures/pie/mirror.png
		tcGen environment
	}
	{
		map $lightmap
		blendFunc filter
	}
	// later, for caustics: reflects as a mirror does, 0.9
}
