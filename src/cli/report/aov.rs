//! AOVs in `--stats`: the depth scale, the cost of rays and their colours.

use crate::{
    cli::write::{AovKind, DepthRange},
    heat::heat,
    render::{Aov, Aovs},
};
use serde::Serialize;

/// What `--stats` says about AOVs.
#[derive(Debug, Serialize)]
pub struct AovReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthRange>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heat: Option<HeatReport>,
}

/// Costs of the rays through the pixel centres, and the colours of costs.
#[derive(Debug, Serialize)]
pub struct HeatReport {
    pub nodes: Costs,
    pub primitives: Costs,
    pub total: Costs,
    pub legend: Vec<Legend>,
}

#[derive(Debug, Serialize)]
pub struct Costs {
    pub mean: f64,
    pub most: u32,
}

/// A cost and its colour, `#rrggbb`.
#[derive(Debug, Serialize)]
pub struct Legend {
    pub cost: u32,
    pub color: String,
}

impl AovReport {
    /// The report for the requested AOVs; `None` if there is nothing to report.
    pub fn new(aovs: &Aovs, asked: &[AovKind], range: DepthRange) -> Option<Self> {
        let costs = |of: &dyn Fn(&Aov) -> u32| Costs {
            mean: aovs.pixels.iter().map(|p| f64::from(of(p))).sum::<f64>() / aovs.pixels.len().max(1) as f64,
            most: aovs.pixels.iter().map(of).max().unwrap_or(0),
        };
        let legend = |power: u32| {
            let cost = 4_u32.pow(power);
            let [r, g, b] = heat(cost);
            Legend {
                cost,
                color: format!("#{r:02x}{g:02x}{b:02x}"),
            }
        };
        let report = Self {
            depth: asked.contains(&AovKind::Depth).then_some(range),
            heat: asked.contains(&AovKind::Heat).then(|| HeatReport {
                nodes: costs(&|p| p.cost.nodes),
                primitives: costs(&|p| p.cost.primitives),
                total: costs(&|p| p.cost.total()),
                legend: (0..=6).map(legend).collect(),
            }),
        };
        (report.depth.is_some() || report.heat.is_some()).then_some(report)
    }

    /// Names and values of the text lines.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(DepthRange { white, black }) = self.depth {
            lines.push(("depth", format!("white at {white}, black at {black}")));
        }
        if let Some(heat) = &self.heat {
            let costs = |what: &str, costs: &Costs| format!("{:.1} {what} (most {})", costs.mean, costs.most);
            lines.push((
                "heat",
                format!(
                    "a pixel's ray costs {}, {}, together {}",
                    costs("nodes", &heat.nodes),
                    costs("primitives", &heat.primitives),
                    costs("on average", &heat.total)
                ),
            ));
            let colors: Vec<String> = heat
                .legend
                .iter()
                .map(|entry| format!("{} {}", entry.cost, entry.color))
                .collect();
            lines.push(("heat legend", colors.join(", ")));
        }
        lines
    }
}
