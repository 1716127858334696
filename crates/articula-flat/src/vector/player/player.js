// The player. `page.rs` strips these comments, indentation and line ends, and the parts between
// `//+shading` and `//-` that a file does not need; every line must end where no line end is
// needed. docs/formats/artv.md tells what is read; names are one letter to keep the file small.
//
// c: canvas; d: the container in base64; e: the element that carries articulaSeek,
// articulaFrames and articulaInputs
async(c,d,e)=>{
let a=new Uint8Array(await new Response(new Response(Uint8Array.from(atob(d),x=>x.charCodeAt()).slice(5)).body
.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer()),
// place in the bytes; points; wedge or number named last; first frame, later start of the clock;
// whether the clock runs
p=0,n=0,o=0,s=0,z=1,
// unsigned, signed and real numbers; lists
{hypot,max,min,round}=Math,
U=_=>{let b,r=0,s=1;do r+=((b=a[p++])&127)*s,s*=128;while(b>127);return r},
V=_=>{let u=U();return u>>>1^-(u&1)},
R=_=>U()/2**U(),
L=(n,f)=>[...Array(n)].map(f),
// width, height, frames, triangles, epochs, components, flags; rate, step, weight of light
[w,h,F,T,E,K,g]=L(7,U),
[r,m,l]=L(3,R),
// point of each wedge; what wedges and points are guessed from; corners; colours
W=[],G=[],H=[],k=[],
I=L(3*T,_=>{let k=W.length,i=k-U(),j;if(i==k){if((j=n-U())==n)H[n++]=W[o]|0;W[k]=j;G[k]=o}return o=i}),
//+gouraud
C=L(W.length,
//+flat
C=L(T,
//-
_=>{let i=U();if(!i)k.push([a[p++],a[p++],a[p++]]);return k.at(-i||-1)}),
// when triangles are drawn, painting orders
B=L(T,_=>(o=0,L(U(),_=>o+=U()))),
O=L(E,_=>(o=-1,[s+=U(),L(U(),_=>o+=1+V())])),
// columns: mean, components with their scale, coefficients of frames
q=H.flatMap(x=>[2*x,2*x+1])
//+gouraud
.concat(G.map(x=>x+2*n))
//-
,D=f=>q.reduce((r,x,i)=>(r[i]=V()+(f&&r[x]|0),r),[]),
M=D(1),
Y=L(K,_=>[R(),D(U())]),
X=L(K,_=>{let m=U(),s=0,d=0;return L(F,_=>s+=d=V()+m*d)}),
//+live
N=L(K,_=>String.fromCharCode(...L(U(),U))),
//+texture
// whether triangles show the picture, in runs; places of wedges in it, in pixels
tx=(b=>{for(let r=[];;b^=1){if(r.length>=T)return r;r.push(...L(U(),_=>b))}})(0),
wt=new Set(I.filter((_,k)=>tx[k/3|0])),
uv=W.reduce((r,_,i)=>{if(wt.has(i))r[i]=(r[G[i]]||[0,0]).map(x=>x+V()/4);return r},[]),
im=(U(),await createImageBitmap(new Blob([a.slice(p)]))),
//-
// point at the end of an edge; triangles on the other side of each edge
y=k=>W[I[k%3<2?k+1:k-2]],
J={},
S=(I.map((i,k)=>(J[[W[i],y(k)]]??=[]).push(k/3|0)),I.map((i,k)=>J[[y(k),W[i]]]||[])),
x=c.getContext("2d"),
//+texture
// the picture in sixteenths of full light, as a pattern; those that were asked for
pt=[],
pl=k=>{if(!pt[k]){let{width:w,height:h}=im,b=new OffscreenCanvas(w,h),y=b.getContext("2d");
y.drawImage(im,0,0);
y.globalCompositeOperation="source-atop";
y.fillStyle=Q([255-k*255/16]);
y.fillRect(0,0,w,h);
pt[k]=x.createPattern(b,"repeat")}return pt[k]},
//-
Z=c.getBoundingClientRect().width*devicePixelRatio/w||1,
//+texture
Q=q=>q[1]+1?`rgb(${q})`:`rgba(0,0,0,${q/255})`,
//+plain
Q=q=>`rgb(${q})`,
//-
// draws a moment, in frames
f=t=>{
t=min(t,F-1);
let i=t|0,u=t-i,y=round(t),v=M.map(x=>x*m),D=B.map(b=>b.filter(x=>x<=y).length&1);
Y.map(([s,b],k)=>{
//+live
let A=e.articulaInputs;
s*=A?256*(A[N[k]]||0):
//+clip
s*=
//-
X[k][i]*(1-u)+(X[k][i+1]||0)*u;
b.map((x,j)=>v[j]+=x*s)});
x.clearRect(0,0,w,h);
O.findLast(o=>o[0]<=y)[1].map(t=>{if(D[t]){
// what is still in D comes later
D[t]=0;
// wedges, places, outward normals as long as their edges, twice the area, parts of normals by which edges move out
let j=I.slice(3*t,3*t+3),
P=j.map(i=>[v[2*W[i]],v[2*W[i]+1]]),
N=P.map((a,i)=>{let b=P[(i+1)%3];return[a[1]-b[1],b[0]-a[0]]}),
A=N[0][0]*N[1][1]-N[0][1]*N[1][0]||1,
z=N.map((a,i)=>S[3*t+i].some(n=>D[n])?.8/Z**.5/hypot(...a):0);
x.beginPath();
P.map((_,i)=>[i,(i+1)%3].map(k=>x.lineTo(P[k][0]+N[i][0]*z[i],P[k][1]+N[i][1]*z[i])));
//+texture
// the picture in the most light, in sixteenths, mapped to the canvas; less light is black over it
let u=min(16,max(1,Math.ceil(16*max(...j.map(i=>v[2*n+i]/l))-.1)));
if(tx[t]){
let pt=pl(u),[[a,b],[c,d],[e,f]]=j.map(i=>uv[i]),
[[g,h],[k,l],[m,o]]=P,
D=(c-a)*(f-b)-(e-a)*(d-b)||1,
q=(g,k,m)=>[((k-g)*(f-b)-(m-g)*(d-b))/D,((m-g)*(c-a)-(k-g)*(e-a))/D],
[A,C]=q(g,k,m),
[B,E]=q(h,l,o);
pt.setTransform({a:A,b:B,c:C,d:E,e:g-A*a-C*b,f:h-B*a-E*b});
x.fillStyle=pt;
x.fill();
x.globalCompositeOperation="source-atop"}
//+gouraud
// colours; square of how far the other two corners' are apart; from i to b they are farthest
//+texture
let q=j.map(i=>tx[t]?[255-255*16/u*v[2*n+i]/l]:C[i].map(x=>x*v[2*n+i]/l)),
//+plain
let q=j.map(i=>C[i].map(x=>x*v[2*n+i]/l)),
//+gouraud
d=q.map((a,i)=>hypot(...q[(i+1)%3].map((x,k)=>x-q[(i+2)%3][k]))**2),
k=d.indexOf(max(...d)),i=(k+1)%3,b=(k+2)%3,
o=(d[b]+d[k]-d[i])/2/d[k]||0,
X=N[k][0]+o*N[i][0],Y=N[k][1]+o*N[i][1],
s=A/(X*X+Y*Y||1),
[B,E]=P[i],
G=x.createLinearGradient(B,E,B+X*s,E+Y*s);
G.addColorStop(0,Q(q[i]));
G.addColorStop(1,Q(q[b]));
x.fillStyle=d[k]<2?Q(q[k]):G;
//+flat
x.fillStyle=`rgb(${C[t]})`;
//-
//+texture
x.fill();
x.globalCompositeOperation="source-over"}});
//+untextured
x.fill()}});
//-
e.articulaFrames=-~e.articulaFrames},
b=t=>{if(z){s??=t;f((t-s)*r/1e3%(F-1||1));requestAnimationFrame(b)}};
c.width=w*Z;
c.height=h*Z;
x.scale(Z,Z);
e.articulaSeek=async t=>{z=0;f(t*r)};
s=null;
f(0);
matchMedia("(prefers-reduced-motion)").matches||requestAnimationFrame(b)
}
