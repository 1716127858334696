<?xml version="1.0" encoding="UTF-8"?>
<!-- Removes units from a generic bitstream syntax description (gBSD, ISO/IEC 21000-7) by their
     markers and renews counts, lengths and padding. XSLT 1.0; addresses in bits, absolute.
     A parameter that is left out keeps everything. -->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:vh="urn:articula:vh:1"
    xmlns:g="urn:mpeg:mpeg21:2003:01-DIA-gBSD-NS" xmlns:cd="urn:mpeg:mpeg21:dia:schema:gBSD:2003"
    exclude-result-prefixes="vh g cd">
<xsl:output method="xml" encoding="UTF-8"/>

<!-- Level of articulation of the body up to which bones stay, 0 to 5: markers L. -->
<xsl:param name="nLayersOut"/>
<!-- Regions of the body that stay, bit r - 1 for region r: markers R. -->
<xsl:param name="regionMask"/>
<!-- Joints that stay, numbers with spaces between: markers J. -->
<xsl:param name="joints"/>
<!-- Finest tier that stays, 0 is the finest: markers T. -->
<xsl:param name="tierOut"/>
<!-- Finest mesh level that stays, 0 is the finest: markers M. -->
<xsl:param name="meshLevelOut"/>
<!-- Finest levels of regions of a mesh, region:level with spaces between: markers R and M. -->
<xsl:param name="meshLevels"/>
<!-- Level of articulation of each of the eight regions of a face, eight digits 0 to 3. -->
<xsl:param name="faceLevels"/>
<!-- Regions of the face that stay, bit r for region r. -->
<xsl:param name="faceRegionMask"/>
<!-- Face parameters (FAP) that stay, numbers with spaces between: markers P. -->
<xsl:param name="fapsOut"/>

<!-- The regions of both masks as numbers between spaces: XSLT 1.0 has no operations on bits. -->
<xsl:variable name="regions">
  <xsl:text> </xsl:text>
{{BODY}}</xsl:variable>
<xsl:variable name="faceRegions">
  <xsl:text> </xsl:text>
{{FACE}}</xsl:variable>

<!-- Descriptions of other programs do not tell what a parameter counts; names of BBA do. -->
<xsl:variable name="foreign" select="not(//*[local-name()='Description']/@vh:tree)"/>

<xsl:key name="unit" match="*[@vh:id]" use="@vh:id"/>

<xsl:template match="/">
  <xsl:if test="not(//{{UNIT}})">
    <xsl:message terminate="yes">no gBSDUnit of the namespace of gBSD or of none</xsl:message>
  </xsl:if>
  <xsl:if test="//@addressMode[translate(., 'ABSOLUTE', 'absolute') != 'absolute'] or //@addressUnit[translate(., 'BIT', 'bit') != 'bit']">
    <xsl:message terminate="yes">addresses must be absolute and in bits</xsl:message>
  </xsl:if>
  <xsl:if test="$nLayersOut != '' and not($nLayersOut &gt;= 0 and $nLayersOut &lt;= 5)">
    <xsl:message terminate="yes">nLayersOut: level out of range, expected 0 to 5</xsl:message>
  </xsl:if>
  <xsl:for-each select="//{{UNIT}}[@syntacticalLabel=':MG4:BoneSegment']">
    <xsl:variable name="masks" select=".//{{UNIT}}[@syntacticalLabel=':MG4:BoneMask']"/>
    <xsl:variable name="values" select=".//{{UNIT}}[@syntacticalLabel=':MG4:BoneValue']"/>
    <xsl:if test="$nLayersOut != '' and ($masks | $values)[not(number(substring-before(substring-after(concat(' ', normalize-space(@marker), ' '), ' L:'), ' ')) &gt;= 0)]">
      <xsl:message terminate="yes">a bone has no marker L: with a level</xsl:message>
    </xsl:if>
    <xsl:if test="count($masks[{{KEEP}}]) != count($values[{{KEEP}}])">
      <xsl:message terminate="yes">a BoneSegment keeps other numbers of masks and of values</xsl:message>
    </xsl:if>
  </xsl:for-each>
  <xsl:apply-templates/>
</xsl:template>

<!-- What is not named below stays as it is. -->
<xsl:template match="@*|node()">
  <xsl:copy>
    <xsl:apply-templates select="@*|node()"/>
  </xsl:copy>
</xsl:template>

<xsl:template match="{{UNITS}}" priority="1">
  <xsl:choose>
    <xsl:when test="not({{KEEP}})">
      <xsl:apply-templates select="." mode="emptied"/>
    </xsl:when>
    <xsl:when test="@vh:padding">
      <xsl:call-template name="padding"/>
    </xsl:when>
    <xsl:when test="*">
      <xsl:copy>
        <xsl:copy-of select="@*"/>
        <xsl:if test="@length">
          <xsl:attribute name="length">
            <xsl:apply-templates select="." mode="length"/>
          </xsl:attribute>
        </xsl:if>
        <xsl:apply-templates select="node()"/>
        <xsl:if test="$foreign and @syntacticalLabel=':MG4:BoneSegment' and not({{PARAMETER}}[@name=':MG4:Padding'])">
          <xsl:variable name="sum">
            <xsl:call-template name="sum">
              <xsl:with-param name="nodes" select="*"/>
            </xsl:call-template>
          </xsl:variable>
          <xsl:variable name="count" select="(8 - (@start + $sum) mod 8) mod 8"/>
          <xsl:if test="$count &gt; 0">
            <xsl:element name="{substring-before(name(), local-name())}Parameter" namespace="{namespace-uri()}">
              <xsl:attribute name="name">:MG4:Padding</xsl:attribute>
              <xsl:attribute name="start"><xsl:value-of select="@start + @length"/></xsl:attribute>
              <xsl:attribute name="length"><xsl:value-of select="$count"/></xsl:attribute>
              <xsl:call-template name="paddingValue">
                <xsl:with-param name="count" select="$count"/>
              </xsl:call-template>
            </xsl:element>
          </xsl:if>
        </xsl:if>
      </xsl:copy>
    </xsl:when>
    <xsl:otherwise>
      <xsl:copy-of select="."/>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- What is left of a removed unit: units whose bytes a parameter counts stay, without bits. -->
<xsl:template match="node()" mode="emptied"/>
<xsl:template match="{{UNITS}}" mode="emptied" priority="1">
  <xsl:choose>
    <xsl:when test="@vh:id">
      <xsl:copy>
        <xsl:copy-of select="@*"/>
        <xsl:attribute name="length">0</xsl:attribute>
        <xsl:apply-templates select="*" mode="emptied"/>
      </xsl:copy>
    </xsl:when>
    <xsl:otherwise>
      <xsl:apply-templates select="*" mode="emptied"/>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<xsl:template match="{{PARAMETERS}}" priority="1">
  <xsl:choose>
    <xsl:when test="@vh:padding or $foreign and @name=':MG4:Padding'">
      <xsl:call-template name="padding"/>
    </xsl:when>
    <xsl:otherwise>
      <xsl:copy>
        <xsl:apply-templates select="@*|node()"/>
      </xsl:copy>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- Padding up to the next whole byte. -->
<xsl:template name="padding">
  <xsl:variable name="count">
    <xsl:apply-templates select="." mode="length"/>
  </xsl:variable>
  <xsl:variable name="prefix" select="substring-before(name(), local-name())"/>
  <xsl:choose>
    <xsl:when test="sum(@length) = $count">
      <xsl:copy-of select="."/>
    </xsl:when>
    <xsl:when test="$count = 0">
      <xsl:if test="@vh:padding">
        <xsl:element name="{$prefix}gBSDUnit" namespace="{namespace-uri()}">
          <xsl:copy-of select="@*[name() != 'name']"/>
          <xsl:attribute name="syntacticalLabel"><xsl:value-of select="@name"/></xsl:attribute>
          <xsl:attribute name="length">0</xsl:attribute>
        </xsl:element>
      </xsl:if>
    </xsl:when>
    <xsl:otherwise>
      <xsl:element name="{$prefix}Parameter" namespace="{namespace-uri()}">
        <xsl:copy-of select="@*[name() != 'syntacticalLabel']"/>
        <xsl:attribute name="name"><xsl:value-of select="@name | @syntacticalLabel"/></xsl:attribute>
        <xsl:attribute name="length"><xsl:value-of select="$count"/></xsl:attribute>
        <xsl:call-template name="paddingValue">
          <xsl:with-param name="count" select="$count"/>
        </xsl:call-template>
      </xsl:element>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<xsl:template name="paddingValue">
  <xsl:param name="count"/>
  <xsl:element name="{substring-before(name(), local-name())}Value" namespace="{namespace-uri()}">
    <xsl:attribute name="xsi:type"><xsl:value-of select="concat('b', $count)"/></xsl:attribute>
    <xsl:value-of select="$count"/>
  </xsl:element>
</xsl:template>

<!-- The value of a parameter that counts something, or a part of it. -->
<xsl:template match="{{VALUES}}" priority="1">
  <xsl:variable name="part" select="sum(../@vh:part)"/>
  <xsl:variable name="first" select="parent::*[$part = 0] | ../preceding-sibling::*[position() = $part]"/>
  <xsl:choose>
    <xsl:when test="$first/@vh:counts or $first/@vh:bytesAfter or $first/@vh:bytesOf or $foreign and $first/@name=':MG4:NoOfBones'">
      <xsl:variable name="number">
        <xsl:call-template name="number">
          <xsl:with-param name="first" select="$first"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:copy>
        <xsl:copy-of select="@*"/>
        <xsl:choose>
          <xsl:when test="$first/@vh:coding='littleEndian'">
            <xsl:call-template name="digit">
              <xsl:with-param name="number" select="$number"/>
              <xsl:with-param name="base" select="256"/>
              <xsl:with-param name="place" select="$part"/>
            </xsl:call-template>
          </xsl:when>
          <xsl:when test="$first/@vh:coding='varint'">
            <xsl:variable name="digit">
              <xsl:call-template name="digit">
                <xsl:with-param name="number" select="$number"/>
                <xsl:with-param name="base" select="128"/>
                <xsl:with-param name="place" select="$part"/>
              </xsl:call-template>
            </xsl:variable>
            <xsl:value-of select="$digit + 128 * number($part + 1 &lt; $first/@vh:parts)"/>
          </xsl:when>
          <xsl:when test="$first/@vh:coding='bigEndian'">
            <xsl:call-template name="digit">
              <xsl:with-param name="number" select="$number"/>
              <xsl:with-param name="base" select="4294967296"/>
              <xsl:with-param name="place" select="$first/@vh:parts - 1 - $part"/>
            </xsl:call-template>
          </xsl:when>
          <xsl:otherwise>
            <xsl:value-of select="$number"/>
          </xsl:otherwise>
        </xsl:choose>
      </xsl:copy>
    </xsl:when>
    <xsl:otherwise>
      <xsl:copy>
        <xsl:apply-templates select="@*|node()"/>
      </xsl:copy>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<xsl:template name="digit">
  <xsl:param name="number"/>
  <xsl:param name="base"/>
  <xsl:param name="place"/>
  <xsl:choose>
    <xsl:when test="$place &gt; 0">
      <xsl:call-template name="digit">
        <xsl:with-param name="number" select="floor($number div $base)"/>
        <xsl:with-param name="base" select="$base"/>
        <xsl:with-param name="place" select="$place - 1"/>
      </xsl:call-template>
    </xsl:when>
    <xsl:otherwise>
      <xsl:value-of select="$number mod $base"/>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- What the parameter counts that is the first part of a number. -->
<xsl:template name="number">
  <xsl:param name="first"/>
  <xsl:variable name="up" select="sum($first/@vh:up) + number($foreign and $first/../@syntacticalLabel=':MG4:MainHeader')"/>
  <xsl:variable name="label">
    <xsl:choose>
      <xsl:when test="$first/@vh:counts"><xsl:value-of select="$first/@vh:counts"/></xsl:when>
      <xsl:otherwise>:MG4:BoneMask</xsl:otherwise>
    </xsl:choose>
  </xsl:variable>
  <xsl:choose>
    <xsl:when test="$first/@vh:bytesOf">
      <xsl:variable name="unit" select="key('unit', $first/@vh:bytesOf)"/>
      <xsl:choose>
        <xsl:when test="$unit/ancestor-or-self::{{UNIT}}[not({{KEEP}})]">0</xsl:when>
        <xsl:otherwise>
          <xsl:variable name="bits">
            <xsl:apply-templates select="$unit" mode="length"/>
          </xsl:variable>
          <xsl:value-of select="ceiling($bits div 8)"/>
        </xsl:otherwise>
      </xsl:choose>
    </xsl:when>
    <xsl:when test="$first/@vh:bytesAfter">
      <xsl:variable name="rest" select="sum($first/@vh:parts) - 1"/>
      <xsl:variable name="bits">
        <xsl:call-template name="after">
          <xsl:with-param name="node" select="$first[$rest &lt; 1] | $first/following-sibling::*[position() = $rest]"/>
          <xsl:with-param name="up" select="$up"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:value-of select="floor($bits div 8)"/>
    </xsl:when>
    <xsl:otherwise>
      <xsl:variable name="owner" select="$first/ancestor::*[local-name()='gBSDUnit'][position() = $up + 1]"/>
      <xsl:value-of select="count($owner/descendant-or-self::*[local-name()='gBSDUnit' and @syntacticalLabel=$label or @vh:padding and @name=$label][not(ancestor-or-self::{{UNIT}}[not({{KEEP}})])])"/>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- Bits from the end of a node to the end of the unit that is `up` units above that around it. -->
<xsl:template name="after">
  <xsl:param name="node"/>
  <xsl:param name="up"/>
  <xsl:variable name="here">
    <xsl:call-template name="sum">
      <xsl:with-param name="nodes" select="$node/following-sibling::*"/>
    </xsl:call-template>
  </xsl:variable>
  <xsl:variable name="above">
    <xsl:choose>
      <xsl:when test="$up &gt; 0">
        <xsl:call-template name="after">
          <xsl:with-param name="node" select="$node/.."/>
          <xsl:with-param name="up" select="$up - 1"/>
        </xsl:call-template>
      </xsl:when>
      <xsl:otherwise>0</xsl:otherwise>
    </xsl:choose>
  </xsl:variable>
  <xsl:value-of select="$here + $above"/>
</xsl:template>

<!-- Bits of some nodes in the output: those without parts at once, the others half by half, so that
     the depth of the recursion is their logarithm. -->
<xsl:template name="sum">
  <xsl:param name="nodes"/>
  <xsl:variable name="plain" select="$nodes[local-name()='gBSDUnit' and not(*) and not(@vh:padding)][{{KEEP}}]"/>
  <xsl:variable name="fixed" select="$nodes[local-name()='Parameter' and not(@vh:padding or $foreign and @name=':MG4:Padding')]"/>
  <xsl:variable name="other">
    <xsl:call-template name="sumOfOther">
      <xsl:with-param name="nodes" select="$nodes[local-name()='gBSDUnit' and (* or @vh:padding) or local-name()='Parameter' and (@vh:padding or $foreign and @name=':MG4:Padding')]"/>
    </xsl:call-template>
  </xsl:variable>
  <xsl:value-of select="sum($plain/@length) + sum($fixed/@length) + $other"/>
</xsl:template>

<xsl:template name="sumOfOther">
  <xsl:param name="nodes"/>
  <xsl:variable name="count" select="count($nodes)"/>
  <xsl:choose>
    <xsl:when test="$count = 0">0</xsl:when>
    <xsl:when test="$count = 1">
      <xsl:apply-templates select="$nodes" mode="length"/>
    </xsl:when>
    <xsl:otherwise>
      <xsl:variable name="half" select="floor($count div 2)"/>
      <xsl:variable name="before">
        <xsl:call-template name="sumOfOther">
          <xsl:with-param name="nodes" select="$nodes[position() &lt;= $half]"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:variable name="after">
        <xsl:call-template name="sumOfOther">
          <xsl:with-param name="nodes" select="$nodes[position() &gt; $half]"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:value-of select="$before + $after"/>
    </xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- Bits of a node in the output. -->
<xsl:template match="node()" mode="length">0</xsl:template>
<xsl:template match="{{PARAMETERS}}" mode="length" priority="1">
  <xsl:choose>
    <xsl:when test="@vh:padding or $foreign and @name=':MG4:Padding'">
      <xsl:call-template name="paddingLength"/>
    </xsl:when>
    <xsl:otherwise><xsl:value-of select="@length"/></xsl:otherwise>
  </xsl:choose>
</xsl:template>
<xsl:template match="{{UNITS}}" mode="length" priority="1">
  <xsl:choose>
    <xsl:when test="not({{KEEP}})">0</xsl:when>
    <xsl:when test="@vh:padding">
      <xsl:call-template name="paddingLength"/>
    </xsl:when>
    <xsl:when test="*">
      <xsl:variable name="sum">
        <xsl:call-template name="sum">
          <xsl:with-param name="nodes" select="*"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:choose>
        <xsl:when test="$foreign and @syntacticalLabel=':MG4:BoneSegment' and not({{PARAMETER}}[@name=':MG4:Padding'])">
          <xsl:value-of select="$sum + (8 - (@start + $sum) mod 8) mod 8"/>
        </xsl:when>
        <xsl:otherwise><xsl:value-of select="$sum"/></xsl:otherwise>
      </xsl:choose>
    </xsl:when>
    <xsl:otherwise><xsl:value-of select="@length"/></xsl:otherwise>
  </xsl:choose>
</xsl:template>

<!-- What is ahead of a segment within its access unit is whole, so that its start tells the bit. -->
<xsl:template name="paddingLength">
  <xsl:variable name="before">
    <xsl:call-template name="sum">
      <xsl:with-param name="nodes" select="preceding-sibling::*"/>
    </xsl:call-template>
  </xsl:variable>
  <xsl:value-of select="(8 - (sum(../@start) + $before) mod 8) mod 8"/>
</xsl:template>
</xsl:stylesheet>
