-- For scripts/theory. Paths of functions lose the brackets in which the table has them; long names may be broken in a line;
-- links to other files of the repository keep their text alone; the table of the paper is set small. On the page
-- what scrolls can be reached with the keyboard, and its text is its main part.

local function breakable(code)
    if not FORMAT:match("latex") then
        return nil
    end
    local special = { ["_"] = "\\_", ["&"] = "\\&", ["%"] = "\\%", ["#"] = "\\#", ["{"] = "\\{", ["}"] = "\\}" }
    local text = code.text:gsub("[_&%%#{}]", special):gsub("([/:]+)", "%1\\allowbreak{}"):gsub("\\_", "\\_\\allowbreak{}")
    -- In the old encoding, whose typewriter font is an outline everywhere.
    return pandoc.RawInline("latex", "{\\fontencoding{OT1}\\ttfamily " .. text .. "}")
end

local function unlinked(link)
    if link.target:match("^%.%./") then
        return link.content
    end
end

-- [`crate::certify`] is text, code, text.
local function unbracketed(inlines)
    for i, inline in ipairs(inlines) do
        if inline.t == "Code" then
            local before, after = inlines[i - 1], inlines[i + 1]
            if before and after and before.t == "Str" and after.t == "Str" and before.text:match("%[$") and after.text:match("^%]") then
                before.text = before.text:gsub("%[$", "")
                after.text = after.text:gsub("^%]", "")
                inline.text = inline.text:gsub("^crate::", "")
            end
        end
    end
    return inlines
end

-- Columns as wide as the square root of their longest cell asks for.
local function small(table)
    if not FORMAT:match("latex") then
        table.attributes.tabindex = "0"
        return table
    end
    local weights, sum = {}, 0
    for column = 1, #table.colspecs do
        local longest = 16
        for _, row in ipairs(table.bodies[1].body) do
            longest = math.max(longest, #pandoc.utils.stringify(row.cells[column].contents))
        end
        weights[column] = math.sqrt(longest)
        sum = sum + weights[column]
    end
    for column, spec in ipairs(table.colspecs) do
        table.colspecs[column] = { spec[1], weights[column] / sum }
    end
    return { pandoc.RawBlock("latex", "{\\footnotesize\\sloppy"), table, pandoc.RawBlock("latex", "}") }
end

local function half_as_wide(image)
    image.attributes.width = "55%"
    return image
end

-- A formula wider than a phone can be moved with the keyboard too.
local function reachable(math)
    if math.mathtype == "DisplayMath" and not FORMAT:match("latex") then
        return pandoc.Span({ math }, { class = "display", tabindex = "0" })
    end
end

local function in_main(document)
    if not FORMAT:match("latex") then
        document.blocks:insert(1, pandoc.RawBlock("html", "<main>"))
        document.blocks:insert(pandoc.RawBlock("html", "</main>"))
        return document
    end
end

return { { Inlines = unbracketed }, { Table = small, Link = unlinked, Image = half_as_wide }, { Code = breakable, Math = reachable, Pandoc = in_main } }
